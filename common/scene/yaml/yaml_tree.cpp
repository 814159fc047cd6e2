// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/yaml/yaml_tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <istream>
#include <limits>
#include <streambuf>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/name_text.hpp"

namespace cbr {

// Appends the parser's events to the tree.
class YamlTreeBuilder final : public YAML::EventHandler {
 public:
  explicit YamlTreeBuilder(YamlTree& tree) : tree_(tree) {}

  // YAML::Load() would stop after the first document, whatever follows.
  void OnDocumentStart(const YAML::Mark& mark) override {
    if (is_second_) {
      throw InputError(tree_.name_ + ":" + std::to_string(mark.line + 1) +
                       ": a second YAML document begins here, or what stands here belongs to none: "
                       "expected one document");
    }
    is_second_ = true;
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(YamlTree::Kind::null, mark, anchor);
  }
  void OnAlias(const YAML::Mark&, YAML::anchor_t anchor) override { hand_on(anchors_.at(anchor)); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    if (const std::string problem = name_problem(value); !problem.empty())
      throw InputError(tree_.name_ + ":" + std::to_string(mark.line + 1) + ": '" +
                       printable_name(value) + "' " + problem +
                       (value.find('\n') != std::string::npos && !unclosed().empty()
                            ? unclosed()
                            : ": write it in UTF-8, without control characters"));
    YamlTree::Value& scalar = add(YamlTree::Kind::scalar, mark, anchor);
    scalar.quoted = tag == "!";
    scalar.first = tree_.text_.size();
    scalar.count = static_cast<std::uint32_t>(value.size());
    tree_.text_ += value;
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value style) override {
    open(YamlTree::Kind::sequence, mark, anchor, style);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value style) override {
    open(YamlTree::Kind::map, mark, anchor, style);
  }
  void OnMapEnd() override { close(); }

  // For messages: the innermost list or map in brackets that is open; empty: none.
  std::string unclosed() const {
    if (open_.empty() || !open_.back().in_brackets) return "";
    const YamlTree::Value& value = tree_.values_[open_.back().id];
    return std::string(": is the ") +
           (value.kind == YamlTree::Kind::map ? "brace {" : "bracket [") + " of line " +
           std::to_string(value.line) + " not closed?";
  }

 private:
  YamlTree::Value& add(YamlTree::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    const auto id = static_cast<YamlTree::Id>(tree_.values_.size());
    if (anchor != 0) {
      if (anchors_.size() <= anchor) anchors_.resize(anchor + 1);
      anchors_[anchor] = id;
    }
    hand_on(id);
    YamlTree::Value& value = tree_.values_.emplace_back();
    value.kind = kind;
    value.line = mark.line + 1;
    return value;
  }

  // To the sequence or map that it stands in.
  void hand_on(YamlTree::Id id) {
    if (!open_.empty()) waiting_.push_back(id);
  }

  void open(YamlTree::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor,
            YAML::EmitterStyle::value style) {
    // The parser's own limit gives no line
    constexpr std::size_t deepest = 100;
    if (open_.size() >= deepest)
      throw InputError(tree_.name_ + ":" + std::to_string(mark.line + 1) +
                       ": lists and maps stand in each other more than " + std::to_string(deepest) +
                       " deep: no part of a scene does, is a bracket not closed?");
    add(kind, mark, anchor);
    open_.push_back({static_cast<YamlTree::Id>(tree_.values_.size() - 1), waiting_.size(),
                     style == YAML::EmitterStyle::Flow});
  }

  // What is in it stands together then.
  void close() {
    const auto [id, first, in_brackets] = open_.back();
    open_.pop_back();
    YamlTree::Value& value = tree_.values_[id];
    value.first = tree_.children_.size();
    value.count = static_cast<std::uint32_t>(waiting_.size() - first);
    tree_.children_.insert(tree_.children_.end(),
                           waiting_.begin() + static_cast<std::ptrdiff_t>(first), waiting_.end());
    waiting_.resize(first);
  }

  YamlTree& tree_;
  bool is_second_ = false;
  std::vector<YamlTree::Id> anchors_;  // by number, from 1
  struct Open {
    YamlTree::Id id;
    std::size_t first;  // of its children among those that wait
    bool in_brackets;
  };
  std::vector<Open> open_;
  std::vector<YamlTree::Id> waiting_;
};

namespace {

// Reads where the text is: a string stream would copy it.
class TextBuffer final : public std::streambuf {
 public:
  explicit TextBuffer(std::string_view text) {
    char* begin = const_cast<char*>(text.data());  // only read from
    setg(begin, begin, begin + text.size());
  }
};

std::string_view line_of(std::string_view text, int line) {
  std::size_t begin = 0;
  for (; line > 0 && begin != std::string_view::npos; --line) {
    begin = text.find('\n', begin);
    if (begin != std::string_view::npos) ++begin;
  }
  return begin == std::string_view::npos ? "" : text.substr(begin, text.find('\n', begin) - begin);
}

// What the parser's words do not say: it takes a tab, or a key that is too long, for a value in a
// wrong place.
std::string cure_of(const YAML::Exception& error, std::string_view text) {
  const std::string_view line = line_of(text, error.mark.line);
  const std::string_view before = error.mark.line > 0 ? line_of(text, error.mark.line - 1) : "";
  for (const std::string_view indented : {line, before}) {
    const auto indentation = indented.substr(0, indented.find_first_not_of(" \t"));
    if (indentation.find('\t') != std::string_view::npos)
      return ": a tab indents it, YAML allows spaces only: replace tabs by spaces";
  }
  constexpr std::size_t longest_key = 1024;
  if (error.msg == YAML::ErrorMsg::MAP_VALUE) {
    const std::string_view key = line.substr(0, static_cast<std::size_t>(error.mark.column));
    const auto start = key.find_last_of("{,");
    if (key.size() - (start == std::string_view::npos ? 0 : start + 1) > longest_key)
      return ": a key has at most 1024 characters: give it a shorter name";
  }
  if (line.find('\t') != std::string_view::npos)
    return ": the line holds a tab: replace it by spaces";
  return "";
}

}  // namespace

YamlTree::YamlTree(std::string_view text, std::string name) : name_(std::move(name)) {
  // The parser lets a null character end the file or become part of a word.
  if (text.find('\0') != std::string_view::npos) throw InputError(name_ + ": is not a text file");
  if (text.size() > std::numeric_limits<std::uint32_t>::max())
    throw InputError(name_ + ": is larger than 4 GB");
  TextBuffer buffer(text);
  std::istream stream(&buffer);
  YamlTreeBuilder builder(*this);
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    const std::string line = error.mark.is_null() ? "" : ":" + std::to_string(error.mark.line + 1);
    std::string cure = error.mark.is_null() ? "" : cure_of(error, text);
    if (cure.empty()) cure = builder.unclosed();
    throw InputError(name_ + line + ": is not valid YAML: " + error.msg + cure);
  }
}

std::string_view YamlTree::text(Id id) const {
  const Value& value = values_[id];
  return value.kind == Kind::scalar ? std::string_view(text_).substr(value.first, value.count)
                                    : std::string_view();
}

std::size_t YamlTree::size(Id id) const {
  const Value& value = values_[id];
  if (value.kind == Kind::map) return value.count / 2;
  return value.kind == Kind::sequence ? value.count : 0;
}

YamlTree::Id YamlTree::item(Id id, std::size_t i) const { return children_[values_[id].first + i]; }
YamlTree::Id YamlTree::key(Id id, std::size_t i) const {
  return children_[values_[id].first + 2 * i];
}
YamlTree::Id YamlTree::value_of_key(Id id, std::size_t i) const {
  return children_[values_[id].first + 2 * i + 1];
}

}  // namespace cbr
