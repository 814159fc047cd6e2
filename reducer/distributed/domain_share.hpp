// SPDX-License-Identifier: GPL-3.0-or-later
// Domains over processes: each reduces its own by the ordinary way, without a message.
#pragma once

#include "reducer/domains/domains.hpp"

namespace cbr {

// Of this process. The first gets the superelements of all. For all processes at the same time.
DomainShare share_of_domains();

}  // namespace cbr
