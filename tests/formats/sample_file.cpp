// SPDX-License-Identifier: GPL-3.0-or-later
// For readers and writers of other languages. usage: sample_file write FILE   writes the sample
// superelement
//                                                    sample_file read FILE    exit 0 when FILE
//                                                    holds the same, number by number
#include <iostream>
#include <string>

#include "common/base/error.hpp"
#include "tests/formats/sample_superelement.hpp"

int main(int argc, char** argv) {
  using namespace cbr;
  if (argc != 3) return 2;
  try {
    if (std::string(argv[1]) == "write") {
      write_superelement(test::sample_superelement(), argv[2]);
      return 0;
    }
    return test::identical(read_superelement(argv[2]), test::sample_superelement()) ? 0 : 1;
  } catch (const InputError& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
