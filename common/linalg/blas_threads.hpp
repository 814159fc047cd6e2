// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace cbr {

// BLAS with one thread while several of ours call it. Objects may overlap, in one thread or in many: the last to go restores what
// the first one found.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;
};

}  // namespace cbr
