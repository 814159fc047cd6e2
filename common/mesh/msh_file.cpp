// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/msh_file.hpp"

#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string_view>

#include "common/error.hpp"

namespace cbr {
namespace {

// A section's contents: numbers as text, or in binary as the machine that wrote them had them.
struct Cursor {
  std::string where;
  std::string_view text;
  bool binary = false;

  [[noreturn]] void fail(const std::string& what) const { throw InputError(where + ": " + what); }

  template <class T>
  T number() {
    T value{};
    if (binary) {
      if (text.size() < sizeof(T)) fail("cut short");
      std::memcpy(&value, text.data(), sizeof(T));
      text.remove_prefix(sizeof(T));
      return value;
    }
    return text_number<T>();
  }

  // Also in binary files some numbers are text.
  template <class T>
  T text_number() {
    T value{};
    const auto start = text.find_first_not_of(" \t\r\n");
    if (start == std::string_view::npos) fail("cut short: a number is missing at the end");
    text.remove_prefix(start);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || (end != text.data() + text.size() && !std::strchr(" \t\r\n", *end)))
      fail("a number should stand where '" + std::string(text.substr(0, std::min<std::size_t>(text.find_first_of(" \t\r\n"), 20))) +
           "' stands");
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return value;
  }

  void skip(std::size_t bytes) {
    if (text.size() < bytes) fail("cut short");
    text.remove_prefix(bytes);
  }

  void end_of_line() {
    const auto end = text.find('\n');
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
};

std::string printable(std::string_view text) {
  std::string shown;
  for (const char c : text.substr(0, 20)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown;
}

std::map<std::string, std::string_view> sections_of(const std::string& contents, const std::string& where) {
  std::map<std::string, std::string_view> sections;
  const std::string_view text = contents;
  std::size_t at = text.find_first_not_of(" \t\r\n");
  while (at != std::string_view::npos) {
    const auto line_end = text.find('\n', at);
    auto name = std::string(text.substr(at, std::min(line_end, text.size()) - at));
    while (!name.empty() && std::strchr(" \t\r", name.back())) name.pop_back();
    if (name.size() < 2 || name[0] != '$')
      throw InputError(where + ": '" + printable(name) + "' stands where a section ($...) should begin: not a whole .msh file");
    if (name == "$NOD")
      throw InputError(where + ": is of MSH format 1; formats 2.2 and 4.1 can be read: convert it with gmsh -save -format msh41");
    const auto body = line_end == std::string_view::npos ? text.size() : line_end + 1;
    const auto end = text.find("$End" + name.substr(1), body);
    if (end == std::string_view::npos)
      throw InputError(where + ": is cut short: section " + printable(name) + " has no $End" + printable(name.substr(1)));
    sections.emplace(name, text.substr(body, end - body));
    at = text.find_first_not_of(" \t\r\n", end + name.size() + 3);
  }
  return sections;
}

// Format 2 repeats an element once for each physical group, and libgmsh keeps the groups by geometrical entity only.
void read_groups(Cursor& cursor, MshFile& msh) {
  static const std::map<int, int> sizes = {{1, 2},  {2, 3},  {3, 4},   {4, 4},   {5, 8},   {6, 6},   {7, 5},
                                           {8, 3},  {9, 6},  {10, 9},  {11, 10}, {12, 27}, {13, 18}, {14, 14},
                                           {15, 1}, {16, 8}, {17, 20}, {18, 15}, {19, 13}};
  Index done = 0;
  while (done < msh.n_elements) {
    int type = 0, count = 1, tags = 0;
    Index number = 0;
    if (!msh.binary) number = cursor.number<Index>();
    type = cursor.number<int>();
    if (msh.binary) count = cursor.number<int>();
    tags = cursor.number<int>();
    const auto size = sizes.find(type);
    if (size == sizes.end())
      cursor.fail("element type " + std::to_string(type) + " is not supported: use elements of first or second order");
    if (count < 1 || count > msh.n_elements - done || tags < 0) cursor.fail("an impossible count of elements or tags");
    for (int i = 0; i < count; ++i) {
      if (msh.binary) number = cursor.number<int>();
      int group = 0;
      for (int t = 0; t < tags; ++t) {
        const int tag = cursor.number<int>();
        if (t == 0) group = tag;
      }
      for (int n = 0; n < size->second; ++n) cursor.number<int>();
      if (!msh.physical.emplace(number, group).second)
        cursor.fail("element number " + std::to_string(number) + " is used twice: numbers must be unique");
    }
    done += count;
  }
}

void read_counts(const std::map<std::string, std::string_view>& sections, const std::string& where, MshFile& msh) {
  const auto cursor = [&](const char* name) {
    const auto section = sections.find(name);
    if (section == sections.end()) throw InputError(where + ": has no section " + name + ": not a mesh, or cut short");
    return Cursor{where + ": section " + name, section->second, msh.binary};
  };
  Cursor nodes = cursor("$Nodes"), elements = cursor("$Elements");
  const bool old = msh.version < 4;
  const auto count = [&](Cursor& c) {
    if (!old) c.number<std::uint64_t>();  // number of entity blocks
    const auto n = old ? c.text_number<std::uint64_t>() : c.number<std::uint64_t>();
    if (n > c.text.size())
      c.fail("announces " + std::to_string(n) + " entries, more than the section can hold: damaged or cut short");
    return static_cast<Index>(n);
  };
  msh.n_nodes = count(nodes);
  msh.n_elements = count(elements);
  if (!old) return;
  if (msh.binary) elements.end_of_line();
  read_groups(elements, msh);
}

}  // namespace

MshFile inspect_msh(const std::filesystem::path& file) {
  const std::string where = file.string();
  std::ifstream stream(file, std::ios::binary);
  const std::string contents((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (!stream) throw InputError(where + ": could not be read");
  const auto start = contents.find_first_not_of(" \t\r\n");
  if (start == std::string::npos) throw InputError(where + ": is empty");
  if (contents[start] != '$')
    throw InputError(where + ": is not a gmsh mesh: it begins with '" + printable(std::string_view(contents).substr(start)) +
                     "', not with $MeshFormat");
  const auto sections = sections_of(contents, where);
  const auto format = sections.find("$MeshFormat");
  if (format == sections.end()) throw InputError(where + ": has no section $MeshFormat: not a gmsh mesh");
  MshFile msh;
  Cursor cursor{where + ": section $MeshFormat", format->second, false};
  msh.version = cursor.number<double>();
  const int kind = cursor.number<int>();
  const int bytes = cursor.number<int>();
  msh.binary = kind == 1;
  const bool known = (msh.version >= 2 && msh.version < 3) || msh.version == 4.1;
  if (!known)
    throw InputError(where + ": is of MSH format " + std::to_string(msh.version).substr(0, 3) +
                     "; formats 2.2 and 4.1 can be read: convert it with gmsh -save -format msh41");
  if ((kind != 0 && kind != 1) || bytes != 8)
    throw InputError(where + ": section $MeshFormat: file type 0 or 1 and data size 8 are allowed, not " + std::to_string(kind) +
                     " and " + std::to_string(bytes));
  if (msh.binary) {
    cursor.end_of_line();
    cursor.binary = true;
    if (cursor.number<int>() != 1)
      throw InputError(where + ": was written in binary on a machine of the other byte order: save it as text there");
  }
  read_counts(sections, where, msh);
  return msh;
}

}  // namespace cbr
