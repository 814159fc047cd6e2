// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/error.hpp"
#include "common/fem/assembly.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/mesh/mesh.hpp"
#include "common/superelement/sierra_superelement.hpp"
#include "tests/fuzz/scratch_folder.hpp"

namespace cbr::fuzz {
namespace {

bool finite(const SparseMatrix& A) {
  return Eigen::Map<const Vector>(A.valuePtr(), A.nonZeros()).allFinite();
}

void use_sets(const Mesh& mesh) {
  for (const Sideset& set : mesh.sidesets) set_nodes(mesh, set.name);
  for (const Nodeset& set : mesh.nodesets) set_nodes(mesh, set.name);
  require(!set_names(mesh).empty(), "sets without a word for them");
}

void use_elements(const Mesh& mesh) {
  if (mesh.coordinates.rows() > 2000) return;
  for (const MassKind mass : {MassKind::lumped, MassKind::consistent}) {
    try {
      const auto model =
          assemble(mesh, std::vector<BlockProperties>(mesh.blocks.size(), {{1, 0.3, 1}}), mass);
      require(finite(model.K), "a stiffness that is not finite");
      require(finite(model.M), "a mass that is not finite");
      require(model.M.diagonal().minCoeff() > 0, "a node without mass");
    } catch (const InputError&) {
    }
  }
}

// Exodus holds what any mesh has, but for long names and large numbers.
void write_and_read(const Mesh& mesh) {
  const ScratchFile copy(".exo");
  try {
    write_mesh(mesh, copy.path());
  } catch (const InputError&) {
    return;
  }
  const Mesh again = read_mesh(copy.path());
  require(again.coordinates == mesh.coordinates && again.node_ids == mesh.node_ids,
          "nodes change when written and read");
  require(again.sidesets.size() == mesh.sidesets.size() &&
              again.nodesets.size() == mesh.nodesets.size(),
          "sets get lost");
}

void read(const std::filesystem::path& file) {
  set_threads(1);
  Mesh mesh;
  try {
    mesh = read_mesh(file);
  } catch (const InputError&) {
    return;
  }
  check_mesh(mesh, "what was read");
  use_sets(mesh);
  use_elements(mesh);
  write_and_read(mesh);
}

}  // namespace

void gmsh(Bytes bytes) { read(ScratchFile(".msh", bytes).path()); }

void med(Bytes bytes) { read(ScratchFile(".med", bytes).path()); }

void exodus(Bytes bytes) {
  const ScratchFile file(".exo", bytes);
  read(file.path());
  try {
    const SierraSuperelement s = read_sierra_superelement(file.path());
    require(s.Kr.allFinite() && s.Mr.allFinite() && s.coordinates.allFinite(),
            "a matrix that is not finite");
  } catch (const InputError&) {
  }
}

}  // namespace cbr::fuzz
