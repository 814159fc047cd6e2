// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/io/deck_lines.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "common/base/error.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

// A few files that include each other twice could go on for ever.
constexpr std::size_t most_files = 1000;

InpKeyword keyword_of(const std::string& line) {
  InpKeyword keyword;
  const auto fields = fields_of(std::string_view(line).substr(1), ',');
  keyword.shown = std::string(fields[0]);
  keyword.name = in_capitals(without_blanks(keyword.shown));
  for (std::size_t i = 1; i < fields.size(); ++i) {
    const auto equals = fields[i].find('=');
    const std::string parameter =
        in_capitals(without_blanks(std::string(fields[i].substr(0, equals))));
    keyword.values[parameter] =
        equals == std::string_view::npos ? "" : unquoted(fields[i].substr(equals + 1));
  }
  return keyword;
}

// Beginnings of words that are not read; without blanks, which do not count.
constexpr const char
    *of_materials =
        "*PLASTIC *CYCLICHARDENING *CREEP *HYPER *VISCO *DEFORMATIONPLASTICITY *MOHR *DRUCKER "
        "*CONCRETE *DAMAGE *DEPVAR *USERMATERIAL MATS CREEP",
    *of_cycles = "CYJOIN CYSYM CYSUP",
    *of_heat = "*EXPANSION *CONDUCTIVITY *SPECIFICHEAT *TEMPERATURE MATT TEMP",
    *of_scenes =
        "*BOUNDARY *CLOAD *DLOAD *DSLOAD *BASEMOTION *INITIALCONDITIONS *AMPLITUDE *STEP *CONTACT "
        "*SURFACEINTERACTION *SURFACEBEHAVIOR *FRICTION *CLEARANCE *GAP *PRE-TENSION *DAMPING "
        "*MODALDAMPING SPC SUPORT FORCE MOMENT PLOAD GRAV RFORCE ACCEL LOAD DLOAD "
        "DAREA RLOAD TLOAD TABLED TIC BC BSURF BOLT TABDMP PARAM, GEof";

std::string reason_of(const std::string& word) {
  const auto is_of = [&](const char* beginnings) {
    const auto all = fields_of(beginnings, ' ');
    return std::any_of(all.begin(), all.end(), [&](std::string_view begin) {
      return without_blanks(word).starts_with(begin);
    });
  };
  if (is_of(of_materials))
    return "not in this version; use linear elasticity, and compare output.stress with the yield "
           "stress";
  if (is_of(of_cycles)) return "cyclic symmetry is not in this version; mesh the whole part";
  if (is_of(of_heat))
    return "not in this version; use contact[].interference for a shrink fit, and loads for other "
           "thermal strain";
  if (is_of(of_scenes)) return "supports, loads, contact, damping and steps are the scene's";
  return "not in this version";
}

}  // namespace

std::string in_capitals(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return out;
}

bool is_among(const std::string& list, const std::string& word) {
  return (" " + list + " ").find(" " + word + " ") != std::string::npos;
}

std::string without_blanks(std::string text) {
  std::erase_if(text, [](char c) { return c == ' ' || c == '\t'; });
  return text;
}

std::string unquoted(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    text = text.substr(1, text.size() - 2);
  return std::string(text);
}

std::string cure_of(const std::vector<Instead>& all, const std::string& word) {
  for (const Instead& of : all)
    if (std::find(of.words.begin(), of.words.end(), word) != of.words.end()) return of.cure;
  return "";
}

void DroppedWords::add(const std::string& word, const DeckPlace& place) {
  const auto known =
      std::find_if(all_.begin(), all_.end(), [&](const Dropped& one) { return one.word == word; });
  if (known != all_.end())
    ++known->count;
  else
    all_.push_back({word, place, 1});
}

std::string DroppedWords::text(const std::filesystem::path& deck, const std::string& last) const {
  std::vector<std::string> reasons;  // each with the words before it
  std::map<std::string, std::vector<std::string>> words;
  for (const Dropped& of : all_) {
    const std::string reason = reason_of(of.word);
    if (!words.contains(reason)) reasons.push_back(reason);
    words[reason].push_back(of.word + " (" +
                            (*of.place.file == deck.string() ? "line " : *of.place.file + ":") +
                            std::to_string(of.place.line) +
                            (of.count > 1      ? ", and " + std::to_string(of.count - 1) + " more"
                             : of.word == last ? " and all after it"
                                               : "") +
                            ")");
  }
  for (std::string& reason : reasons) reason = join(words[reason]) + ": " + reason;
  return join(reasons, "; ");
}

bool InpKeyword::is(const std::string& word) const { return name == without_blanks(word); }

std::string InpKeyword::value(const std::string& parameter) const {
  const auto found = values.find(parameter);
  return found == values.end() ? "" : found->second;
}

void DeckPlace::fail(const std::string& what) const {
  throw InputError(*file + ":" + std::to_string(line) + ": " + what);
}

DeckLines::DeckLines(const fs::path& file, Kind kind) : kind_(kind) { open(file); }

void DeckLines::open(const fs::path& file) {
  levels_.push_back(
      Level{file, std::make_shared<const std::string>(file.string()), TextLines(file, true)});
  files_.push_back(file);
}

// Abaqus and CalculiX take names from the folder of the deck, people from that of the file.
void DeckLines::include(std::string name) {
  const std::string include = kind_ == Kind::inp ? "*INCLUDE: " : "INCLUDE: ";
  if (name.empty()) fail(include + "found without the name of a file");
  std::error_code error;
  std::replace(name.begin(), name.end(), '\\', '/');  // of Windows
  fs::path file = (levels_.back().file.parent_path() / name).lexically_normal();
  if (const fs::path other = (levels_.front().file.parent_path() / name).lexically_normal();
      !fs::exists(file, error) && fs::exists(other, error))
    file = other;
  for (const Level& level : levels_)
    if (fs::equivalent(level.file, file, error))
      fail(include + file.string() + " includes itself: take one of the includes out");
  if (files_.size() >= most_files)
    fail(include + "more than " + std::to_string(most_files) +
         " files found: write them into fewer");
  try {
    open(file);
  } catch (const InputError& wrong) {
    fail(include + wrong.what() +
         (fs::exists(file, error)
              ? ": include a text file that can be read"
              : ": give its path from the folder of this file or of the first one"));
  }
}

bool DeckLines::next() {
  if (!data_file_.empty()) include(std::exchange(data_file_, {}));
  while (true) {
    if (levels_.back().lines.next()) {
      line_ = levels_.back().lines.line();
      if (kind_ == Kind::inp ? take_inp_line() : take_bdf_line()) return true;
    } else if (levels_.size() == 1) {
      return false;
    } else {
      levels_.pop_back();
    }
  }
}

// Whether it is to be read, as it includes no file.
bool DeckLines::take_inp_line() {
  const std::string_view start = trimmed(line_);
  if (!start.starts_with('*') || start.starts_with("**")) return true;
  line_ = std::string(start);
  TextLines& lines = levels_.back().lines;
  while (line_.ends_with(',') && lines.next()) line_ += std::string(trimmed(lines.line()));
  keyword_ = keyword_of(line_);
  if (keyword_.is("STEP")) includes_ = false;
  if (!includes_) return true;
  if (keyword_.is("INCLUDE")) {
    include(keyword_.value("INPUT"));
    return false;
  }
  if (keyword_.is("NODE") || keyword_.is("ELEMENT")) data_file_ = keyword_.value("INPUT");
  return true;
}

// INCLUDE 'FILE', whose name may go on in other lines up to the second quote.
bool DeckLines::take_bdf_line() {
  const std::string start = in_capitals(trimmed(line_).substr(0, 8));
  if (start.starts_with("ENDDATA")) includes_ = false;
  if (!includes_ || !start.starts_with("INCLUDE") ||
      (start.size() == 8 && std::string_view(" \t='\"").find(start[7]) == std::string_view::npos))
    return true;
  std::string name(trimmed(trimmed(line_).substr(7)));
  if (name.starts_with('=')) name = std::string(trimmed(std::string_view(name).substr(1)));
  if (name.starts_with('\'') || name.starts_with('"')) {
    const char quote = name[0];
    TextLines& lines = levels_.back().lines;
    while (name.find(quote, 1) == std::string::npos && lines.next())
      name += std::string(trimmed(lines.line()));
    name = name.substr(1, name.find(quote, 1) - 1);
  } else {
    name = name.substr(0, name.find_first_of(" \t$"));
  }
  include(name);
  return false;
}

}  // namespace cbr
