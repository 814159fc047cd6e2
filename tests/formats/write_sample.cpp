// SPDX-License-Identifier: GPL-3.0-or-later
// Writes the sample superelement, for readers of other languages.
#include "tests/formats/sample_superelement.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  cbr::write_superelement(cbr::test::sample_superelement(), argv[1]);
  return 0;
}
