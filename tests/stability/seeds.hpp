// SPDX-License-Identifier: GPL-3.0-or-later
// Seeds of random scenes, and how to repeat one.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace cbr::test {

struct Seeds {
  unsigned first = 1, count = 40;
  bool thorough = false;  // every change of every scene
};

// CBR_SEEDS=FIRST:COUNT: every change is tried on these scenes. Without it 1 to `count`.
inline Seeds seeds(unsigned count = 40) {
  Seeds seeds{1, count};
  if (const char* text = std::getenv("CBR_SEEDS"))
    seeds.thorough = std::sscanf(text, "%u:%u", &seeds.first, &seeds.count) == 2;
  return seeds;
}

inline std::string command(unsigned seed) {
  return "again: CBR_SEEDS=" + std::to_string(seed) + ":1 build/tests/stability/random_scenes";
}

// The worst value of each kind.
class Worst {
 public:
  void add(const std::string& what, double share, double value, unsigned seed) {
    Entry& entry = entries_[what];
    ++entry.n;
    if (share >= entry.share) {
      entry.share = share;
      entry.value = value;
      entry.seed = seed;
    }
  }
  int count(const std::string& what) const {
    const auto entry = entries_.find(what);
    return entry == entries_.end() ? 0 : entry->second.n;
  }
  void print() const {
    for (const auto& [what, entry] : entries_)
      std::printf("%-40s %6d scenes, worst %.1e (seed %u, %.2g of what is allowed)\n", what.c_str(),
                  entry.n, entry.value, entry.seed, entry.share);
  }

 private:
  struct Entry {
    int n = 0;
    double share = 0, value = 0;
    unsigned seed = 0;
  };
  std::map<std::string, Entry> entries_;
};

}  // namespace cbr::test
