// SPDX-License-Identifier: GPL-3.0-or-later
// Grammar: gmsh's manual, "MSH file format" (4.1) and "MSH file format version 2 (Legacy)".

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <string_view>

#include "common/base/error.hpp"
#include "common/base/text_lines.hpp"
#include "common/mesh/io/gmsh_types.hpp"

namespace cbr {
namespace {

// A section's contents: numbers as text, or in binary as the machine that wrote them had them.
struct MshCursor {
  std::string where;  // "block.msh: section $Nodes"
  std::string_view text;
  bool binary = false;

  [[noreturn]] void fail(const std::string& what) const { throw InputError(where + ": " + what); }

  template <class T>
  T number() {
    if (!binary) return text_number<T>();
    T value{};
    if (text.size() < sizeof(T)) fail("is cut short or damaged");
    std::memcpy(&value, text.data(), sizeof(T));
    text.remove_prefix(sizeof(T));
    return value;
  }

  // Also in binary files some numbers are text.
  template <class T>
  T text_number() {
    constexpr std::string_view blanks = " \t\r\n";
    const auto start = text.find_first_not_of(blanks);
    if (start == std::string_view::npos) fail("is cut short: a number is missing at its end");
    text.remove_prefix(start);
    if (text[0] == '+') text.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const auto length = static_cast<std::size_t>(end - text.data());
    if (error == std::errc::result_out_of_range)
      fail("the number '" + std::string(text.substr(0, std::min<std::size_t>(length, 30))) +
           "' is out of range");
    if (error != std::errc() ||
        (length < text.size() && blanks.find(text[length]) == std::string_view::npos))
      fail("a number should stand where '" +
           std::string(text.substr(0, std::min<std::size_t>(text.find_first_of(blanks), 20))) +
           "' stands");
    text.remove_prefix(length);
    return value;
  }

  // How many entries follow; each takes at least a byte.
  std::size_t count() { return bounded(number<std::uint64_t>()); }
  std::size_t text_count() { return bounded(text_number<std::uint64_t>()); }
  std::size_t bounded(std::uint64_t n) const {
    if (n > text.size())
      fail("announces " + std::to_string(n) +
           " entries, more than it can hold: damaged or cut short");
    return static_cast<std::size_t>(n);
  }

  void skip_doubles(std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) number<double>();
  }

  // The rest of the line, and past its end.
  std::string_view line() {
    const auto end = std::min(text.find('\n'), text.size());
    const auto found = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return found;
  }

  void expect_end() const {
    if (!binary && text.find_first_not_of(" \t\r\n") != std::string_view::npos)
      fail("holds more than it announces: damaged");
  }
};

using Sections = std::map<std::string, std::string_view>;

std::string printable(std::string_view text) {
  std::string shown;
  for (const char c : text.substr(0, 20)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown;
}

// Others may be there any number of times: data of several fields and times.
bool is_read(const std::string& section) {
  for (const char* read : {"$MeshFormat", "$PhysicalNames", "$Entities", "$PartitionedEntities",
                           "$Nodes", "$ParametricNodes", "$Elements"})
    if (section == read) return true;
  return false;
}

Sections sections_of(std::string_view text, const std::string& where) {
  Sections sections;
  std::size_t at = text.find_first_not_of(" \t\r\n");
  while (at != std::string_view::npos) {
    const auto line_end = std::min(text.find('\n', at), text.size());
    auto name = std::string(text.substr(at, line_end - at));
    name.erase(name.find_last_not_of(" \t\r") + 1);
    if (name.size() < 2 || name[0] != '$')
      throw InputError(
          where + ": '" + printable(name) +
          "' found where a section ($...) should begin: the .msh file is damaged or incomplete");
    if (name == "$NOD")
      throw InputError(where +
                       ": is of MSH format 1; formats 2.2 and 4.1 can be read: convert it with "
                       "gmsh -save -format msh41");
    const auto body = std::min(line_end + 1, text.size());
    const auto end = text.find("$End" + name.substr(1), body);
    if (end == std::string_view::npos)
      throw InputError(where + ": is cut short: section " + printable(name) + " has no $End" +
                       printable(name.substr(1)));
    const bool is_new = sections.emplace(name, text.substr(body, end - body)).second;
    if (!is_new && is_read(name))
      throw InputError(where + ": section " + name +
                       " appears twice: the file holds two meshes or is damaged");
    at = text.find_first_not_of(" \t\r\n", end + name.size() + 3);
  }
  return sections;
}

class Reader {
 public:
  Reader(const Sections& sections, std::string where)
      : sections_(sections), where_(std::move(where)) {}

  MshFile run() {
    read_format();
    if (sections_.count("$PhysicalNames")) read_names();
    if (msh_.version < 4) {
      read_old_nodes();
      read_old_elements();
    } else {
      for (const bool partitioned : {false, true})
        if (sections_.count(partitioned ? "$PartitionedEntities" : "$Entities"))
          read_entities(partitioned);
      read_nodes();
      read_elements();
    }
    return std::move(msh_);
  }

 private:
  MshCursor open(const char* name) const {
    const auto section = sections_.find(name);
    if (section == sections_.end())
      throw InputError(where_ + ": has no section " + name + ": not a mesh, or cut short");
    return {where_ + ": section " + name, section->second, msh_.binary};
  }

  void read_format() {
    MshCursor cursor = open("$MeshFormat");
    msh_.version = cursor.number<double>();
    const int kind = cursor.number<int>(), bytes = cursor.number<int>();
    if (!(msh_.version >= 2 && msh_.version < 3) && msh_.version != 4.1)
      throw InputError(
          where_ + ": is of MSH format " + std::to_string(msh_.version).substr(0, 3) +
          "; formats 2.2 and 4.1 can be read: convert it with gmsh -save -format msh41");
    if ((kind != 0 && kind != 1) || bytes != 8)
      cursor.fail("file type 0 or 1 and data size 8 are allowed, not " + std::to_string(kind) +
                  " and " + std::to_string(bytes));
    msh_.binary = kind == 1;
    if (!msh_.binary) return;
    cursor.line();
    cursor.binary = true;
    if (cursor.number<int>() != 1)
      cursor.fail("written in binary on a machine of the other byte order: save it as text there");
  }

  void read_names() {
    MshCursor cursor = open("$PhysicalNames");
    const auto n = cursor.text_count();
    for (std::size_t i = 0; i < n; ++i) {
      const int dimension = cursor.text_number<int>();
      const Index tag = cursor.text_number<int>();
      const auto line = cursor.line();
      const auto open_quote = line.find('"'), close_quote = line.rfind('"');
      if (open_quote == close_quote)
        cursor.fail("the name of group " + std::to_string(tag) + " is not in quotes");
      msh_.group_names[{dimension, std::abs(tag)}] =
          std::string(line.substr(open_quote + 1, close_quote - open_quote - 1));
    }
  }

  void refuse_part(const std::string& n_parts, std::size_t n_held) const {
    throw InputError(where_ + ": is one file of a mesh that is split into " + n_parts +
                     ", and holds " + std::to_string(n_held) +
                     ": save the mesh in one file (gmsh: Mesh.PartitionSplitMeshFiles = 0)");
  }

  void read_entities(bool partitioned) {
    MshCursor cursor = open(partitioned ? "$PartitionedEntities" : "$Entities");
    std::set<int> parts;  // of the entities of the highest dimension: others are shared
    std::size_t n_parts = 0;
    if (partitioned) {
      n_parts = cursor.count();
      const auto ghosts = cursor.count();
      for (std::size_t i = 0; i < 2 * ghosts; ++i) cursor.number<int>();
    }
    std::array<std::size_t, 4> n{};
    for (auto& count : n) count = cursor.count();
    const auto skip_list = [&] {
      const auto length = cursor.count();
      for (std::size_t i = 0; i < length; ++i) cursor.number<int>();
    };
    for (int d = 0; d < 4; ++d)
      for (std::size_t e = 0; e < n[d]; ++e) {
        const Index tag = cursor.number<int>();
        if (e == 0) parts.clear();
        if (partitioned) {
          cursor.number<int>();
          cursor.number<int>();  // the parent
          const auto length = cursor.count();
          for (std::size_t i = 0; i < length; ++i) parts.insert(cursor.number<int>());
        }
        cursor.skip_doubles(d == 0 ? 3 : 6);
        auto& groups = msh_.groups_of_entity[{d, tag}];
        const auto length = cursor.count();
        for (std::size_t i = 0; i < length; ++i)
          groups.push_back(std::abs(Index{cursor.number<int>()}));
        if (d > 0) skip_list();  // its boundary
      }
    if (parts.size() < n_parts) refuse_part(std::to_string(n_parts), parts.size());
    cursor.expect_end();
  }

  void add_node(Index id, MshCursor& cursor) {
    if (id < 1) cursor.fail("node number " + std::to_string(id) + " found, numbers are at least 1");
    msh_.node_ids.push_back(id);
  }

  // $ParametricNodes (Mesh.SaveParametric): behind the coordinates the dimension and tag of the
  // entity, and where on a curve or surface the node is.
  void read_old_nodes() {
    const bool parametric = sections_.count("$ParametricNodes") > 0;
    MshCursor cursor = open(parametric ? "$ParametricNodes" : "$Nodes");
    const auto n = cursor.text_count();
    if (msh_.binary) cursor.line();
    for (std::size_t i = 0; i < n; ++i) {
      add_node(cursor.number<int>(), cursor);
      for (int c = 0; c < 3; ++c) msh_.coordinates.push_back(cursor.number<double>());
      if (!parametric) continue;
      const int dimension = cursor.number<int>();
      cursor.number<int>();
      if (dimension == 1 || dimension == 2)
        cursor.skip_doubles(static_cast<std::size_t>(dimension));
    }
    cursor.expect_end();
  }

  void read_nodes() {
    MshCursor cursor = open("$Nodes");
    const auto n_blocks = cursor.count(), n = cursor.count();
    cursor.number<std::uint64_t>();
    cursor.number<std::uint64_t>();  // lowest and highest number
    for (std::size_t b = 0; b < n_blocks; ++b) {
      const int dimension = cursor.number<int>();
      cursor.number<int>();  // the entity
      const int parametric = cursor.number<int>();
      if (dimension < 0 || dimension > 3)
        cursor.fail("dimension " + std::to_string(dimension) + " found, allowed are 0 to 3");
      const auto rows = cursor.count();
      for (std::size_t i = 0; i < rows; ++i)
        add_node(static_cast<Index>(cursor.number<std::uint64_t>()), cursor);
      for (std::size_t i = 0; i < rows; ++i) {
        for (int c = 0; c < 3; ++c) msh_.coordinates.push_back(cursor.number<double>());
        if (parametric != 0) cursor.skip_doubles(static_cast<std::size_t>(dimension));
      }
    }
    if (msh_.node_ids.size() != n)
      cursor.fail("announces " + std::to_string(n) + " nodes and holds " +
                  std::to_string(msh_.node_ids.size()) + ": damaged");
    cursor.expect_end();
  }

  const GmshType& known_type(int type, const MshCursor& cursor) const {
    const GmshType* known = find_gmsh_type(type);
    if (known == nullptr)
      cursor.fail("element type " + gmsh_type_name(type) + " is not supported: mesh with " +
                  supported_gmsh_types());
    return *known;
  }

  template <class T>
  void add_element(MshElement element, int n_nodes, MshCursor& cursor) {
    if (element.id < 1)
      cursor.fail("element number " + std::to_string(element.id) +
                  " found, numbers are at least 1");
    element.first = msh_.element_nodes.size();
    for (int i = 0; i < n_nodes; ++i)
      msh_.element_nodes.push_back(static_cast<Index>(cursor.number<T>()));
    msh_.elements.push_back(element);
  }

  void read_old_elements() {
    MshCursor cursor = open("$Elements");
    const auto n = cursor.text_count();
    if (msh_.binary) cursor.line();
    std::set<Index> parts;  // of the elements
    Index last_part = 0;    // of ghosts, too
    while (msh_.elements.size() < n) {
      MshElement element;
      if (!msh_.binary) element.id = cursor.number<int>();
      element.type = cursor.number<int>();
      const int rows = msh_.binary ? cursor.number<int>() : 1;
      const int tags = cursor.number<int>();
      const GmshType& type = known_type(element.type, cursor);
      element.dimension = type.dimension;
      if (rows < 1 || static_cast<std::size_t>(rows) > n - msh_.elements.size() || tags < 0)
        cursor.fail("an impossible count of elements or tags: damaged");
      for (int r = 0; r < rows; ++r) {
        if (msh_.binary) element.id = cursor.number<int>();
        element.group = element.entity = 0;
        // The group, the entity, the number of partitions, its own, and those that have its ghost
        bool has_parts = false;
        for (int t = 0; t < tags; ++t) {
          const Index tag = std::abs(Index{cursor.number<int>()});
          if (t == 0) element.group = tag;
          if (t == 1) element.entity = tag;
          if (t == 2) has_parts = tag == tags - 3;
          if (t == 3 && has_parts) parts.insert(tag);
          if (t >= 3 && has_parts) last_part = std::max(last_part, tag);
        }
        add_element<int>(element, type.n_nodes, cursor);
      }
    }
    // gmsh numbers partitions where it makes two or more. Of the first part's file only the nodes
    // that it leaves out show that it is one.
    const bool lacks_nodes = std::ranges::any_of(
        msh_.node_ids, [&](Index id) { return id > std::ssize(msh_.node_ids); });
    if (std::ssize(parts) < last_part || (last_part == 1 && lacks_nodes))
      refuse_part(std::to_string(std::max(last_part, Index{2})) + " or more", parts.size());
    cursor.expect_end();
  }

  void read_elements() {
    MshCursor cursor = open("$Elements");
    const auto n_blocks = cursor.count(), n = cursor.count();
    cursor.number<std::uint64_t>();
    cursor.number<std::uint64_t>();
    for (std::size_t b = 0; b < n_blocks; ++b) {
      MshElement element;
      element.dimension = cursor.number<int>();
      element.entity = cursor.number<int>();
      element.type = cursor.number<int>();
      const GmshType& type = known_type(element.type, cursor);
      if (element.dimension != type.dimension)
        cursor.fail("elements of dimension " + std::to_string(type.dimension) +
                    " in an entity of dimension " + std::to_string(element.dimension) +
                    ": damaged");
      const auto rows = cursor.count();
      for (std::size_t r = 0; r < rows; ++r) {
        element.id = static_cast<Index>(cursor.number<std::uint64_t>());
        add_element<std::uint64_t>(element, type.n_nodes, cursor);
      }
    }
    if (msh_.elements.size() != n)
      cursor.fail("announces " + std::to_string(n) + " elements and holds " +
                  std::to_string(msh_.elements.size()) + ": damaged");
    cursor.expect_end();
  }

  const Sections& sections_;
  std::string where_;
  MshFile msh_;
};

}  // namespace

MshFile read_msh(const std::filesystem::path& file) {
  const std::string where = file.string();
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)),
                          std::istreambuf_iterator<char>());
  if (!stream) throw InputError(where + ": could not be read");
  const std::string_view contents = without_mark(bytes, where);
  const auto start = std::min(contents.find_first_not_of(" \t\r\n"), contents.size());
  if (start == contents.size() || contents[start] != '$')
    throw InputError(where + (start == contents.size() ? ": is empty"
                                                       : ": is not a gmsh mesh: it begins with '" +
                                                             printable(contents.substr(start)) +
                                                             "', not with $MeshFormat"));
  const Sections sections = sections_of(contents, where);
  return Reader(sections, where).run();
}

}  // namespace cbr
