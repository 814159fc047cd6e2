// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/error.hpp"
#include "common/linalg/blas_threads.hpp"
#include "tests/formats/sample_superelement.hpp"
#include "tests/fuzz/read_superelement.hpp"
#include "tests/fuzz/scratch_folder.hpp"

namespace cbr::fuzz {
namespace {

template <class Read, class Write>
bool survives(const std::filesystem::path& file, Read read, Write write) {
  decltype(read(file)) first;
  try {
    first = read(file);
  } catch (const InputError&) {
    return false;
  }
  const ScratchFile copy(".cbr.h5");
  write(first, copy.path());  // what was read obeys every rule
  require(test::identical(first, read(copy.path())),
          "a superelement changes when written and read");
  return true;
}

}  // namespace

bool read_any_superelement(const std::filesystem::path& file) {
  set_threads(1);
  read_content_hash(file);
  const auto one = [](const auto& name) { return read_superelement(name); };
  const auto group = [](const auto& name) { return read_superelement_group(name); };
  return survives(file, one,
                  [](const auto& s, const auto& name) { write_superelement(s, name); }) ||
         survives(file, group,
                  [](const auto& g, const auto& name) { write_superelement_group(g, name); });
}

void superelement(Bytes bytes) { read_any_superelement(ScratchFile(".cbr.h5", bytes).path()); }

}  // namespace cbr::fuzz
