// SPDX-License-Identifier: GPL-3.0-or-later
// A YAML document as a few arrays: some 30 bytes a value beside its text, where a tree of objects
// takes ten times that.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cbr {

class YamlTree {
 public:
  using Id = std::uint32_t;
  enum class Kind : char { null, scalar, sequence, map };

  // `name` is for messages. InputError "NAME:LINE: ...": not YAML, more than one document, a null
  // character. Aliases are followed; an anchor may hold itself.
  YamlTree(std::string_view text, std::string name);

  const std::string& name() const { return name_; }
  bool empty() const { return values_.empty(); }  // no document, or one of comments only
  Id root() const { return 0; }
  Kind kind(Id id) const { return values_[id].kind; }
  int line(Id id) const { return values_[id].line; }  // from 1
  // Of a scalar that stands in quotes: whatever it reads, it is no word of YAML's.
  bool is_quoted(Id id) const { return values_[id].quoted; }
  std::string_view text(Id id) const;           // of a scalar, else empty
  std::size_t size(Id id) const;                // of a sequence; of a map its keys
  Id item(Id id, std::size_t i) const;          // of a sequence
  Id key(Id id, std::size_t i) const;           // of a map, in the order of the text
  Id value_of_key(Id id, std::size_t i) const;  // the value beside that key

 private:
  friend class YamlTreeBuilder;
  struct Value {
    // in text_, of a scalar; in children_, of a sequence or a map: keys and values in turn
    std::uint64_t first = 0;
    std::uint32_t count = 0;
    int line = 0;
    Kind kind = Kind::null;
    bool quoted = false;
  };

  std::string name_;
  std::vector<Value> values_;
  std::vector<Id> children_;
  std::string text_;
};

}  // namespace cbr
