// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/error.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace cbr {
namespace {

// Levenshtein distance, case folded: "Youngs_modulus" is a near miss of "youngs_modulus".
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const bool same = std::tolower(static_cast<unsigned char>(a[i])) ==
                        std::tolower(static_cast<unsigned char>(b[j]));
      const std::size_t substituted = diagonal + (same ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string join(const std::vector<std::string>& words, const std::string& separator) {
  std::string joined;
  for (const auto& word : words) joined += (joined.empty() ? "" : separator) + word;
  return joined;
}

std::string nearest_name(const std::string& found, const std::vector<std::string>& allowed) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, found.size() / 3) + 1;
  constexpr std::size_t longest = 200;  // the distance takes time in proportion to both lengths
  if (found.size() > longest) return "";
  for (const auto& name : allowed) {
    if (name.size() > longest) continue;
    const auto distance = edit_distance(found, name);
    if (distance < best_distance) {
      best_distance = distance;
      best = name;
    }
  }
  return best.empty() ? "" : ", did you mean '" + best + "'?";
}

}  // namespace cbr
