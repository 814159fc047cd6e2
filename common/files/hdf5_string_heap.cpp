// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/hdf5_string_heap.hpp"

#include <cstdint>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "common/base/child_process.hpp"

namespace cbr::hdf5 {
namespace {

constexpr std::uint64_t largest_whole = std::uint64_t{64} << 20,
                        window_size = std::uint64_t{16} << 20, overlap = 1 << 16;
constexpr std::string_view signature("GCOL\x01");  // and version 1
constexpr std::uint64_t header = 16;               // of a collection and of an object in it
constexpr std::uint64_t longest_string = std::uint64_t{1} << 20;

// Part of the file from `begin`. Heaps that begin before `end` are looked at, and end within the
// bytes that follow.
struct Window {
  std::uint64_t begin = 0, end = 0;
  std::string bytes;
};

// Little-endian, as the format has it everywhere.
std::uint64_t number(std::string_view bytes, std::uint64_t at, int size) {
  std::uint64_t value = 0;
  for (int i = size; i-- > 0;)
    value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::uint64_t>(i)]);
  return value;
}

using Sizes = std::map<std::uint64_t, std::uint64_t>;  // of the objects of a collection, by index

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

bool heaps_are_sound(const Window& window, const std::vector<Window>& windows) {
  const std::string_view bytes = window.bytes;
  for (auto at = bytes.find(signature); at < window.end - window.begin;
       at = bytes.find(signature, at + 1)) {
    const Sizes sizes = read_collection(bytes.substr(at));
    for (const auto& other : windows) {
      if (!references_are_sound(other.bytes, window.begin + at, sizes)) return false;
    }
  }
  return true;
}

Window read(std::ifstream& in, std::uint64_t begin, std::uint64_t size) {
  Window window{begin, begin + size, std::string(size + overlap, '\0')};
  in.seekg(static_cast<std::streamoff>(begin));
  in.read(window.bytes.data(), static_cast<std::streamsize>(size + overlap));
  window.bytes.resize(in.gcount());
  in.clear();  // the end of the file may come before that of the overlap
  return window;
}

bool look_through(const std::filesystem::path& file, std::uint64_t size) {
  std::ifstream in(file, std::ios::binary);
  if (!in.is_open()) return false;
  std::vector<Window> windows;
  if (size <= largest_whole) {
    windows.push_back(read(in, 0, size));
  } else {
    windows.push_back(read(in, 0, window_size));
    windows.push_back(read(in, size - window_size, window_size));
  }
  for (const auto& window : windows) {
    if (!heaps_are_sound(window, windows)) return false;
  }
  return true;
}

}  // namespace

bool is_sound(const std::filesystem::path& file, bool whole, const std::function<void()>& visit) {
  // A file is opened several times, for its hash, its light parts, its matrices: one look at its
  // bytes is enough
  using Seen =
      std::tuple<std::filesystem::path, std::uint64_t, std::filesystem::file_time_type, bool>;
  static std::mutex mutex;
  static std::map<Seen, bool> known;
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(file, error);
  if (error) return false;
  const Seen seen{std::filesystem::absolute(file, error), size,
                  std::filesystem::last_write_time(file, error), whole};
  const std::scoped_lock lock(mutex);
  const auto it = known.find(seen);
  if (it != known.end() && !error) return it->second;
  constexpr std::size_t most = 10000;
  if (known.size() >= most) known.clear();
  return known[seen] = look_through(file, size) &&
                       survives_in_child(file.string(), visit, seconds_to_read(size));
}

}  // namespace cbr::hdf5
