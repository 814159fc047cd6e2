// SPDX-License-Identifier: GPL-3.0-or-later
// fuzz_replay TARGET FILE-OR-FOLDER...: the target's inputs one after the other, with any compiler.
// What once was found stays mended: an input that crashes, hangs (20 s) or asks for more than 4 GB
// of memory ends the program.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/targets.hpp"

#ifdef __SANITIZE_ADDRESS__  // g++
#define CBR_HAS_ADDRESS_SANITIZER
#elif defined(__has_feature)  // clang; a library's header may define it, as 0, for g++ too
#if __has_feature(address_sanitizer)
#define CBR_HAS_ADDRESS_SANITIZER
#endif
#endif

namespace {

void limit_memory() {
#ifndef CBR_HAS_ADDRESS_SANITIZER  // it keeps shadows of terabytes
  const rlimit limit{rlim_t{4} << 30, rlim_t{4} << 30};
  setrlimit(RLIMIT_AS, &limit);
#endif
}

std::vector<std::filesystem::path> inputs(int argc, char** argv) {
  std::vector<std::filesystem::path> files;
  for (int i = 2; i < argc; ++i) {
    if (!std::filesystem::is_directory(argv[i])) {
      files.emplace_back(argv[i]);
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(argv[i]))
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view name = argc > 1 ? argv[1] : "";
  const auto* target = std::find_if(std::begin(cbr::fuzz::targets), std::end(cbr::fuzz::targets),
                                    [&](const cbr::fuzz::Target& t) { return t.name == name; });
  const auto files = inputs(argc, argv);
  if (target == std::end(cbr::fuzz::targets) || files.empty()) {
    std::fprintf(stderr, "usage: fuzz_replay TARGET FILE-OR-FOLDER...\n");
    return 2;
  }
  limit_memory();
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    std::fprintf(stderr, "%s\n", file.filename().c_str());  // the last line tells which one it was
    alarm(20);
    target->run({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    alarm(0);
  }
  std::fprintf(stderr, "%zu inputs\n", files.size());
  return 0;
}
