// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/hdf5_handle.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "common/base/process.hpp"

namespace cbr::hdf5 {
namespace {

constexpr std::uint64_t largest_whole = std::uint64_t{64} << 20,
                        ends_looked_at = std::uint64_t{16} << 20;
constexpr std::string_view signature("GCOL\x01");  // and version 1
constexpr std::uint64_t header = 16;               // of a collection and of an object in it
constexpr std::uint64_t longest_string = std::uint64_t{1} << 20;
constexpr std::uint64_t window_size = 4 * longest_string, overlap = longest_string + (1 << 16);

// Little-endian, as the format has it everywhere.
std::uint64_t number(std::string_view bytes, std::uint64_t at, int size) {
  std::uint64_t value = 0;
  for (int i = size; i-- > 0;)
    value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::uint64_t>(i)]);
  return value;
}

using Sizes = std::map<std::uint64_t, std::uint64_t>;  // of the objects of a collection, by index
using Heaps = std::map<std::uint64_t, Sizes>;          // by address

// Three reserved bytes, the size, and objects that follow each other: index, reference count,
// reserved, size, data padded to 8 bytes. Index 0 is the free space at the end, its size counts the
// header. Empty for any other layout.
Sizes read_collection(std::string_view bytes) {
  if (bytes.size() < header) return {};
  const std::uint64_t end = number(bytes, 8, 8);
  if (number(bytes, 5, 3) != 0 || end < header || end > bytes.size()) return {};
  Sizes sizes;
  for (std::uint64_t at = header; at + header <= end;) {
    const std::uint64_t index = number(bytes, at, 2), size = number(bytes, at + 8, 8);
    if (index == 0) return size == end - at ? sizes : Sizes();
    if (size > end - at - header || !sizes.emplace(index, size).second) return {};
    at += header + (size + 7) / 8 * 8;
  }
  return sizes;
}

// In front of an attribute's value stands its dataspace; that of one value is {2, 0, 0, 0}, in
// older files {1, 0, 0, 0, 0, 0, 0, 0}.
bool follows_scalar_space(std::string_view bytes, std::uint64_t at) {
  return (at >= 4 && number(bytes, at - 4, 4) == 2) || (at >= 8 && number(bytes, at - 8, 8) == 1);
}

// A heap that nothing points to does no harm, and may be other data that looks like one.
// A string stands in the file as its length (4 bytes), the collection's address (8) and the
// object's index (4). The library copies the object's size into a buffer of that length.
bool references_are_sound(std::string_view bytes, std::uint64_t address, const Sizes& sizes) {
  std::string pattern(8, '\0');
  for (std::size_t i = 0; i < 8; ++i) pattern[i] = static_cast<char>(address >> 8 * i & 0xff);
  for (auto at = bytes.find(pattern); at != std::string_view::npos;
       at = bytes.find(pattern, at + 1)) {
    // the address by chance
    if (at < 4 || at + 12 > bytes.size() || !follows_scalar_space(bytes, at - 4)) continue;
    const std::uint64_t length = number(bytes, at - 4, 4);
    if (length == 0 || length > longest_string) continue;
    const auto object = sizes.find(number(bytes, at + 8, 4));
    if (object == sizes.end() || object->second != length) return false;
  }
  return true;
}

// Calls look(bytes, begin, size) for the parts of the file from begin to begin + size, in one
// buffer. Heaps that begin there end within the bytes that follow. False once look() is.
template <typename Look>
bool each_window(const std::filesystem::path& file, std::uint64_t size, const Look& look) {
  std::ifstream in(file, std::ios::binary);
  if (!in.is_open()) return false;
  std::string bytes(std::min(size, window_size + overlap), '\0');
  const auto part = [&](std::uint64_t begin, std::uint64_t end) {
    for (; begin < end; begin += window_size) {
      in.clear();  // the end of the file may come before that of the overlap
      in.seekg(static_cast<std::streamoff>(begin));
      in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      const std::string_view read(bytes.data(), static_cast<std::size_t>(in.gcount()));
      if (!look(read, begin, std::min(window_size, end - begin))) return false;
    }
    return true;
  };
  if (size <= largest_whole) return part(0, size);
  return part(0, ends_looked_at) && part(size - ends_looked_at, size);
}

bool look_through(const std::filesystem::path& file, std::uint64_t file_size) {
  Heaps heaps;
  const auto find_heaps = [&](std::string_view bytes, std::uint64_t begin, std::uint64_t size) {
    for (auto at = bytes.find(signature); at < size; at = bytes.find(signature, at + 1))
      heaps[begin + at] = read_collection(bytes.substr(at));
    return true;
  };
  const auto check = [&](std::string_view bytes, std::uint64_t, std::uint64_t) {
    return std::all_of(heaps.begin(), heaps.end(), [&](const auto& heap) {
      return references_are_sound(bytes, heap.first, heap.second);
    });
  };
  return each_window(file, file_size, find_heaps) && each_window(file, file_size, check);
}

}  // namespace

bool is_sound(const std::filesystem::path& file, bool whole, const std::function<void()>& visit) {
  // A file is opened several times, for its hash, its light parts, its matrices: one look at its
  // bytes is enough, and one visit of each kind
  using File = std::tuple<std::filesystem::path, std::uint64_t, std::filesystem::file_time_type>;
  struct Known {
    bool has_sound_bytes = false;
    std::optional<bool> survives[2];  // a visit of the root's attributes, of the whole file
  };
  static std::mutex mutex;
  static std::map<File, Known> all;
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(file, error);
  if (error) return false;
  const auto written = std::filesystem::last_write_time(file, error);
  if (error) return false;
  const std::scoped_lock lock(mutex);
  constexpr std::size_t most = 10000;
  if (all.size() >= most) all.clear();
  const auto [it, is_new] = all.try_emplace({std::filesystem::absolute(file), size, written});
  Known& known = it->second;
  if (is_new) known.has_sound_bytes = look_through(file, size);
  std::optional<bool>& survives = known.survives[whole ? 1 : 0];
  if (known.has_sound_bytes && !survives)
    survives = survives_in_child(file.string(), visit, seconds_to_read(size));
  return known.has_sound_bytes && *survives;
}

}  // namespace cbr::hdf5
