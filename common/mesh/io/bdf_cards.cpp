// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/io/bdf_cards.hpp"

#include <algorithm>

#include "common/base/error.hpp"

namespace cbr {
namespace {

constexpr std::size_t small = 8, large = 16, last_column = 72;

std::string_view columns(const std::string& line, std::size_t first, std::size_t width) {
  return first < line.size() ? trimmed(std::string_view(line).substr(first, width))
                             : std::string_view();
}

// Without the comment, with tabs as blanks up to the next field.
std::string plain(const std::string& line) {
  std::string out;
  for (const char c : line) {
    if (c == '$') break;
    out += c == '\t' ? ' ' : c;
    while (c == '\t' && out.size() % small != 0) out += ' ';
  }
  return out;
}

std::string name_of(const std::string& line) {
  const auto comma = line.find(',');
  return in_capitals(trimmed(comma == std::string::npos ? columns(line, 0, small)
                                                        : std::string_view(line).substr(0, comma)));
}

}  // namespace

BdfCards::BdfCards(const std::filesystem::path& file) : lines_(file, DeckLines::Kind::bdf) {
  // A file may begin with the executive and case control sections
  DeckLines all(file, DeckLines::Kind::bdf);
  is_bulk_ = true;
  // A whole deck ends with ENDDATA, and so does what gmsh writes; bulk data alone need not
  while (all.next()) {
    if (all.line().find('\0') != std::string::npos)
      all.fail("is no text: expected bulk data of Nastran");
    const std::string start = in_capitals(trimmed(plain(all.line()).substr(0, 40)));
    if (start.starts_with("BEGIN") && start.find("BULK") != std::string::npos) is_bulk_ = false;
    is_of_gmsh_ |= all.line().starts_with("$ Created by Gmsh");
  }
  must_end_ = !is_bulk_ || is_of_gmsh_;
}

bool BdfCards::next_line() {
  while (!has_line_) {
    if (!lines_.next()) return false;
    line_ = plain(lines_.line());
    const std::string_view text = trimmed(line_);
    if (text.empty()) continue;
    if (!is_bulk_) {
      is_bulk_ = in_capitals(text.substr(0, 5)) == "BEGIN";
      continue;
    }
    has_line_ = true;
  }
  return true;
}

bool BdfCards::is_continuation() const {
  const std::string name = name_of(line_);
  return name.empty() || name[0] == '+' || name[0] == '*';
}

void BdfCards::add_fields(BdfCard& card) const {
  if (line_.find(',') != std::string::npos) {
    const auto fields = fields_of(line_, ',');
    // the tenth marks the continuation
    const std::size_t wanted = std::min<std::size_t>(fields.size(), 9);
    for (std::size_t i = 1; i < wanted; ++i) card.fields.emplace_back(fields[i]);
    if (wanted < 9) card.fields.resize(card.fields.size() + 9 - wanted);
    return;
  }
  const bool is_large = columns(line_, 0, small).find('*') != std::string_view::npos;
  const std::size_t width = is_large ? large : small;
  for (std::size_t first = small; first < last_column; first += width)
    card.fields.emplace_back(columns(line_, first, width));
}

std::optional<BdfCard> BdfCards::next() {
  if (!next_line()) {
    if (must_end_) lines_.fail("ends without ENDDATA: the file is cut short, export it again");
    return std::nullopt;
  }
  BdfCard card{name_of(line_), {}, lines_.place()};
  if (card.name == "ENDDATA") return std::nullopt;
  if (is_continuation()) fail(card, "a continuation without the card before it");
  if (card.name.ends_with('*')) card.name.pop_back();
  card.name = std::string(trimmed(card.name));
  do {
    add_fields(card);
    has_line_ = false;
  } while (next_line() && is_continuation());
  return card;
}

std::string BdfCards::text(const BdfCard& card, std::size_t i) const {
  return i < card.fields.size() ? card.fields[i] : "";
}

Index BdfCards::whole(const BdfCard& card, std::size_t i) const {
  const std::string field = text(card, i);
  if (field.empty() ||
      field.find_first_not_of("0123456789", field[0] == '+' ? 1 : 0) != std::string::npos ||
      field.size() > 15)
    fail(card,
         "'" + field + "' found in field " + std::to_string(i + 2) + ", expected a whole number");
  return std::stoll(field);
}

double BdfCards::real(const BdfCard& card, std::size_t i, double blank) const {
  std::string field = text(card, i);
  if (field.empty()) return blank;
  // An exponent may stand without a letter
  const auto sign = field.find_last_of("+-");
  if (sign != std::string::npos && sign > 0 &&
      std::string_view("0123456789.").find(field[sign - 1]) != std::string_view::npos)
    field.insert(sign, "E");
  const auto exponent = field.find_first_of("eEdD");
  if (exponent != std::string::npos && exponent + 1 < field.size() && field[exponent + 1] == '+')
    field.erase(exponent + 1, 1);
  try {
    return lines_.number(field);
  } catch (const InputError&) {  // which has the line after the card
    fail(card, "'" + text(card, i) + "' found, expected a finite number");
  }
}

}  // namespace cbr
