// SPDX-License-Identifier: GPL-3.0-or-later
// Values of a stress in files: components, von Mises and principal values.
#pragma once

#include <array>
#include <string_view>

#include "common/base/types.hpp"

namespace cbr {

// The columns of stress_values(), in order. Each has a name of its own, as readers do not agree on
// the order of a tensor's.
inline constexpr std::array<std::string_view, 10> stress_names = {
    "xx", "yy", "zz", "xy", "yz", "xz", "von_mises", "principal_1", "principal_2", "principal_3"};
inline constexpr Index n_stress_values = 10, von_mises_column = 6;

// m x 10 from m x 6 (xx yy zz xy yz xz): the same; von Mises' sqrt(((xx - yy)^2 + (yy - zz)^2 + (zz
// - xx)^2) / 2
// + 3 (xy^2 + yz^2 + xz^2)); the principal stresses, the largest (most tension) first.
Matrix stress_values(const Matrix& stress);

// The same stress in axes turned by T, x' = T x (which may mirror): T sigma T^T, m x 6.
Matrix turned_stress(const Matrix& stress, const Matrix3& T);

}  // namespace cbr
