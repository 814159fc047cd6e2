// SPDX-License-Identifier: GPL-3.0-or-later
// Bulk data of Nastran: cards of small fields (8 columns), large ones (16), or between commas, over
// as many lines as they take. MSC Nastran Quick Reference Guide, "Format of Bulk Data Entries".
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/io/deck_lines.hpp"

namespace cbr {

struct BdfCard {
  std::string name;  // in capitals, without an asterisk
  // those after the name, trimmed; continuations follow one another
  std::vector<std::string> fields;
  DeckPlace place;
};

class BdfCards {
 public:
  explicit BdfCards(const std::filesystem::path& file);

  bool is_of_gmsh() const { return is_of_gmsh_; }
  // The next card of the bulk data; none after ENDDATA or the last line.
  std::optional<BdfCard> next();
  // InputError "FILE:LINE: what", with the card's line.
  [[noreturn]] void fail(const BdfCard& card, const std::string& what) const {
    card.place.fail(card.name + ": " + what);
  }

  // Field i, from 0. Empty: none, or blank.
  std::string text(const BdfCard& card, std::size_t i) const;
  // InputError unless a whole number
  Index whole(const BdfCard& card, std::size_t i) const;
  // "1.5", "1.5E3", "1.5D3" and "1.5+3"
  double real(const BdfCard& card, std::size_t i, double blank) const;

 private:
  bool next_line();
  bool is_continuation() const;
  void add_fields(BdfCard& card) const;

  DeckLines lines_;
  std::string line_;  // without comment, tabs expanded
  bool has_line_ = false, is_bulk_ = false;
  bool must_end_ = false, is_of_gmsh_ = false;  // with ENDDATA; of gmsh
};

}  // namespace cbr
