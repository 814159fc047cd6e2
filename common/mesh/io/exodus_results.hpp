// SPDX-License-Identifier: GPL-3.0-or-later
// Exodus II with values over time, as post-processors read it (ParaView, SEACAS).
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace cbr {

// Names of the values; components of a vector are scalars called NAME_x, NAME_y, NAME_z, which
// readers join.
struct ExodusVariables {
  std::vector<std::string> nodal, element;
  // per block of the mesh: how many of the values `element`, the first ones, its elements have
  std::vector<std::size_t> of_block;
};

// Writes the mesh, then one step after the other, then close(). Every step has every value once.
// The same calls give the same bytes. InputError: a mesh without elements. RunError when the disk
// refuses. `where` stands for the file in messages.
class ExodusResults {
 public:
  ExodusResults(const Mesh& mesh, const ExodusVariables& variables, const std::string& title,
                const std::filesystem::path& file, const std::string& where);
  ~ExodusResults();
  // seconds
  void begin_step(double t);
  // nodes of the mesh
  void write_nodal(std::size_t variable, const std::vector<double>& values);
  // elements of the block
  void write_element(std::size_t variable, std::size_t block, const std::vector<double>& values);
  void close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cbr
