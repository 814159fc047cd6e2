// SPDX-License-Identifier: GPL-3.0-or-later
// The error of a rejected input.
#pragma once

#include "common/base/error.hpp"

#include <string>

namespace cbr::test {

/// The message of the InputError that `work`() ends with; "no InputError" when it does not.
template <class Work>
std::string refusal_of(Work&& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

}  // namespace cbr::test
