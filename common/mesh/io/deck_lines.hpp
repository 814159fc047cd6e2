// SPDX-License-Identifier: GPL-3.0-or-later
// Lines of an input deck with the files that it includes. For the .cpp of this folder.
#pragma once

#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/text_lines.hpp"

namespace cbr {

std::string in_capitals(std::string_view text);
// Whether the word is among those of a list with blanks between.
bool is_among(const std::string& list, const std::string& word);

// Words of a deck, in capitals without blanks, and the cure of errors about them.
struct Instead {
  const char* cure;
  std::vector<const char*> words;
};
std::string cure_of(const std::vector<Instead>& all, const std::string& word);  // empty: none
inline constexpr const char
    *instead_of_ties =
        "a scene ties surfaces of two instances (contact: tied: true): give each "
        "part a mesh of its own",
    *instead_of_equations =
        "not in this version: a scene has points that move with a set "
        "(points: coupling), links between them, and tied contact",
    *instead_of_points =
        "not in this version; use RBE2, RBE3 or *COUPLING, or take it out: a scene has points "
        "that move with a set, and may have a mass (components.NAME.points: coupling, mass)",
    *instead_of_springs =
        "take it out: a scene has springs, dashpots and joints between points (links)",
    *instead_of_gaps = "take it out: a scene has contact between surfaces (contact)";

// A keyword line of Abaqus or CalculiX.
struct InpKeyword {
  std::string name;   // in capitals, without the asterisk and blanks
  std::string shown;  // as spelled
  // parameter in capitals -> value as spelled, "" when it has none
  std::map<std::string, std::string> values;

  bool is(const std::string& word) const;
  bool has(const std::string& parameter) const { return values.count(parameter) > 0; }
  std::string value(const std::string& parameter) const;
};
std::string without_blanks(std::string text);  // which do not count inside keywords and parameters
std::string unquoted(std::string_view text);

// Of a line, or of what it says.
struct DeckPlace {
  std::shared_ptr<const std::string> file;
  Index line = 0;
  [[noreturn]] void fail(const std::string& what) const;  // InputError "FILE:LINE: what"
};

// Words of a deck that are not read, for Mesh::dropped: each with the line of its first.
class DroppedWords {
 public:
  void add(const std::string& word, const DeckPlace& place);
  // Lines are those of this file, unless another is named. `last`: all after it are not read.
  std::string text(const std::filesystem::path& deck, const std::string& last = "") const;

 private:
  struct Dropped {
    std::string word;
    DeckPlace place;
    Index count = 0;
  };
  std::vector<Dropped> all_;
};

class DeckLines {
 public:
  enum class Kind { inp, bdf };

  // InputError: the file cannot be opened, or is no regular file.
  DeckLines(const std::filesystem::path& file, Kind kind);

  // The next line, where an include is replaced by the lines of its file; false after the last one.
  // Of an .inp a keyword comes with the lines that continue it. Files are included up to the first
  // *STEP, or ENDDATA. InputError with the line of the include: its file is missing or no regular
  // one, includes itself, or is one too many.
  bool next();
  const std::string& line() const { return line_; }
  // Of a line of an .inp that begins with one asterisk.
  const InpKeyword& keyword() const { return keyword_; }
  DeckPlace place() const { return {levels_.back().name, levels_.back().lines.count()}; }
  bool includes() const { return includes_; }  // whether from here on
  const std::vector<std::filesystem::path>& files() const { return files_; }  // read so far

  [[noreturn]] void fail(const std::string& what) const { place().fail(what); }
  // as those of TextLines
  double number(std::string_view field) const { return levels_.back().lines.number(field); }
  Index whole(std::string_view field) const { return levels_.back().lines.whole(field); }

 private:
  struct Level {
    std::filesystem::path file;
    std::shared_ptr<const std::string> name;
    TextLines lines;
  };

  void open(const std::filesystem::path& file);
  void include(std::string name);
  bool take_inp_line();
  bool take_bdf_line();

  const Kind kind_;
  std::deque<Level> levels_;
  std::vector<std::filesystem::path> files_;
  std::string line_;
  InpKeyword keyword_;
  std::string data_file_;  // INPUT of the keyword before
  bool includes_ = true;
};

}  // namespace cbr
