// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <netcdf.h>

#include <cmath>
#include <cstdlib>

#include "common/mesh/mesh.hpp"
#include "common/mesh/surface.hpp"
#include "sample_meshes.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::exodus_mesh_test {
namespace {

using test::refusal_of;
using test::TemporaryFolder;

// Two hexes, a quadrilateral shell and an empty block as another program might write them: any
// format, either way of coordinates, any spelling, no maps, no names.
struct Foreign {
  int mode = NC_CLASSIC_MODEL;
  bool joint_coordinates = false;
  std::string hex = "HEX", shell = "SHELL";
  int bad_node = 0;     // instead of node 12 of the second hex
  int bad_element = 0;  // instead of 2 in the sideset
  std::string leave_out;

  void write(const std::filesystem::path& file) const {
    const Mesh brick = test::brick(1, 1, 2);
    int f = -1;
    ok(nc_create(file.c_str(), NC_CLOBBER | mode, &f));
    const auto dim = [&](const char* name, std::size_t n) {
      int id = -1;
      ok(nc_def_dim(f, name, n, &id));
      return id;
    };
    const auto var = [&](const std::string& name, int type, std::vector<int> dims) {
      int id = -1;
      if (name != leave_out)
        ok(nc_def_var(f, name.c_str(), type, static_cast<int>(dims.size()), dims.data(), &id));
      return id;
    };
    const int d = dim("num_dim", 3), n = dim("num_nodes", 12);
    dim("num_elem", 3);
    const int nb = dim("num_el_blk", 3), rows = dim("num_el_in_blk1", 2),
              cols = dim("num_nod_per_el1", 8);
    const int rows3 = dim("num_el_in_blk3", 1), cols3 = dim("num_nod_per_el3", 4),
              ns = dim("num_side_sets", 2);
    const int sides = dim("num_side_ss1", 2);
    const int ids = var("eb_prop1", NC_INT, {nb}), status = var("eb_status", NC_INT, {nb}),
              set_ids = var("ss_prop1", NC_INT, {ns});
    const int joint = joint_coordinates ? var("coord", NC_FLOAT, {d, n}) : -1;
    std::array<int, 3> xyz{};
    for (std::size_t c = 0; c < 3 && !joint_coordinates; ++c)
      xyz[c] = var(std::string("coord") + "xyz" [c], NC_DOUBLE, { n });
    const int c1 = var("connect1", NC_INT, {rows, cols}),
              c3 = var("connect3", NC_INT, {rows3, cols3});
    const int elements = var("elem_ss1", NC_INT, {sides}),
              numbers = var("side_ss1", NC_INT, {sides});
    if (c1 >= 0) ok(nc_put_att_text(f, c1, "elem_type", hex.size(), hex.c_str()));
    ok(nc_put_att_text(f, c3, "elem_type", shell.size(), shell.c_str()));
    ok(nc_enddef(f));
    put(f, ids, {30, 20, 10});
    put(f, status, {1, 0, 1});
    put(f, set_ids, {5, 6});
    std::vector<double> all;
    for (Index c = 0; c < 3; ++c) {
      std::vector<double> column(brick.coordinates.col(c).begin(), brick.coordinates.col(c).end());
      all.insert(all.end(), column.begin(), column.end());
      if (!joint_coordinates && xyz[c] >= 0) ok(nc_put_var_double(f, xyz[c], column.data()));
    }
    if (joint >= 0) ok(nc_put_var_double(f, joint, all.data()));
    std::vector<int> nodes;
    for (const Index node : brick.blocks[0].connectivity.reshaped<Eigen::RowMajor>())
      nodes.push_back(static_cast<int>(node) + 1);
    if (bad_node != 0) nodes.back() = bad_node;
    put(f, c1, nodes);
    put(f, c3, {9, 10, 12, 11});
    put(f, elements, {1, bad_element != 0 ? bad_element : 2});
    put(f, numbers, {5, 6});
    ok(nc_close(f));
  }
  static void ok(int status) { ASSERT_EQ(status, NC_NOERR) << nc_strerror(status); }
  static void put(int f, int variable, const std::vector<int>& values) {
    if (variable >= 0) ok(nc_put_var_int(f, variable, values.data()));
  }
};

TEST(ExodusMesh, readsEveryFlavour) {
  const TemporaryFolder folder;
  const Mesh brick = test::brick(1, 1, 2);
  for (const int mode :
       {NC_CLASSIC_MODEL, NC_64BIT_OFFSET, NC_NETCDF4, NC_NETCDF4 | NC_CLASSIC_MODEL})
    for (const bool joint : {false, true})
      for (const char* word : {"HEX", "HEX8", "hex", "Hexahedron"}) {
        Foreign foreign{mode, joint, word, "shell4", 0, 0, ""};
        foreign.write(folder / "f.exo");
        const Mesh mesh = read_mesh(folder / "f.exo");
        EXPECT_EQ(mesh.coordinates, brick.coordinates);
        EXPECT_EQ(mesh.node_ids, brick.node_ids);
        ASSERT_EQ(mesh.blocks.size(), 2U);
        EXPECT_EQ(mesh.blocks[0].name, "block_30");
        EXPECT_EQ(mesh.blocks[0].connectivity, brick.blocks[0].connectivity);
        EXPECT_EQ(mesh.blocks[1].name, "block_10");
        EXPECT_EQ(mesh.blocks[1].type, ElementType::quad4);
        EXPECT_EQ(mesh.blocks[1].element_ids, std::vector<Index>{3});
        ASSERT_EQ(mesh.sidesets.size(), 2U);
        EXPECT_EQ(mesh.sidesets[find_sideset(mesh, "5")].sides,
                  (std::vector<Side>{{0, 0, 5}, {0, 1, 6}}));
        EXPECT_TRUE(mesh.sidesets[find_sideset(mesh, "surface_6")].sides.empty());
      }
}

TEST(ExodusMesh, theNumberOfNodesDecidesTheType) {
  const TemporaryFolder folder;
  for (const char* word : {"TRI", "TRIANGLE", "BAR", "SPHERE", "SUPER", ""}) {
    Foreign foreign;
    foreign.shell = word;
    foreign.write(folder / "f.exo");
    const auto message = refusal_of([&] { read_mesh(folder / "f.exo"); });
    EXPECT_SAYS(message, "'block_10'", "with 4 nodes");
  }
  for (const char* word : {"QUAD4", "quad", "SHELL", "SHELL4"}) {
    Foreign foreign;
    foreign.shell = word;
    foreign.write(folder / "f.exo");
    EXPECT_EQ(read_mesh(folder / "f.exo").blocks[1].type, ElementType::quad4);
  }
}

TEST(ExodusMesh, writtenAndReadBackIsTheSame) {
  const TemporaryFolder folder;
  Mesh zoo = test::zoo();
  zoo.coordinates *= M_PI / 3;
  zoo.sidesets.push_back({"empty", 11, {}});
  zoo.nodesets.push_back({"a name that is longer than the thirty-two characters of old", 12, {7}});
  // A side of a shell: its face.
  zoo.sidesets.push_back({"shell faces", 12, {{find_block(zoo, "block of quad4"), 0, 1}}});
  for (const char* name : {"zoo.exo", "zoo.e", "zoo.g"}) {
    write_mesh(zoo, folder / name);
    test::expect_equal(zoo, read_mesh(folder / name));
  }
  EXPECT_EQ(test::bytes_of(folder / "zoo.exo"), test::bytes_of(folder / "zoo.g"));
  EXPECT_EQ(folder.n_entries(), 3U);
}

TEST(ExodusMesh, throughGmshAndBackIsTheSame) {
  const TemporaryFolder folder;
  const Mesh zoo = test::zoo();
  write_mesh(zoo, folder / "zoo.msh");
  write_mesh(read_mesh(folder / "zoo.msh"), folder / "zoo.exo");
  Mesh back = read_mesh(folder / "zoo.exo");
  test::expect_equal(zoo, back);
}

TEST(ExodusMesh, faultsAreNamed) {
  const TemporaryFolder folder;
  const auto fault = [&](const Foreign& foreign, const std::string& part) {
    foreign.write(folder / "f.exo");
    const auto message = refusal_of([&] { read_mesh(folder / "f.exo"); });
    EXPECT_SAYS(message, part);
    EXPECT_EQ(message.rfind((folder / "f.exo").string() + ": ", 0), 0U) << message;
  };
  for (const int mode : {NC_64BIT_OFFSET, NC_NETCDF4}) {
    fault({mode, false, "HEX", "SHELL", 13, 0, ""}, "connect1: node number 13");
    fault({mode, false, "HEX", "SHELL", -1, 0, ""}, "connect1: node number -1");
    fault({mode, false, "HEX", "SHELL", 0, 4, ""}, "elem_ss1: element number 4");
    for (const char* name : {"coordy", "connect1", "elem_ss1", "side_ss1"})
      fault({mode, false, "HEX", "SHELL", 0, 0, name}, name);
  }
  test::write_bytes(folder / "g.exo", "solid cube\n");
  EXPECT_SAYS(refusal_of([&] { read_mesh(folder / "g.exo"); }), "not an Exodus II");
  test::write_bytes(folder / "g.exo", "");
  EXPECT_NE(refusal_of([&] { read_mesh(folder / "g.exo"); }), "no error");
}

TEST(ExodusMesh, cutShortIsAnErrorAlways) {
  const TemporaryFolder folder;
  Foreign{NC_NETCDF4, false, "HEX", "SHELL", 0, 0, ""}.write(folder / "a.exo");
  Foreign{NC_64BIT_OFFSET, false, "HEX", "SHELL", 0, 0, ""}.write(folder / "b.exo");
  write_mesh(test::zoo(), folder / "c.exo");
  for (const char* name : {"a.exo", "b.exo", "c.exo"}) {
    const std::string whole = test::bytes_of(folder / name);
    for (std::size_t i = 0; i < 50; ++i) {
      test::write_bytes(folder / "cut.exo", whole.substr(0, whole.size() * i / 50));
      EXPECT_THROW(read_mesh(folder / "cut.exo"), InputError) << name << " " << i;
    }
    test::write_bytes(folder / "cut.exo", whole.substr(0, whole.size() - 4));
    EXPECT_THROW(read_mesh(folder / "cut.exo"), InputError) << name;
  }
}

TEST(ExodusMesh, flippedBytesNeverCrash) {
  const TemporaryFolder folder;
  write_mesh(test::brick(2, 1, 1), folder / "whole.exo");
  const std::string whole = test::bytes_of(folder / "whole.exo");
  int refused = 0;
  for (std::size_t i = 0; i < whole.size(); i += 3) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ (i % 2 == 0 ? 0x80 : 0x21));
    test::write_bytes(folder / "d.exo", damaged);
    try {
      read_mesh(folder / "d.exo");
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(ExodusMesh, readsASierraFile) {
  const char* set = std::getenv("CBR_SHARED_DATA");
  const auto file = std::filesystem::path(set != nullptr ? set : CBR_SOURCE_DIR "/../shared/data") /
                    "sierra" / "block_1-eig.exo";
  if (!std::filesystem::exists(file))
    GTEST_SKIP() << "no folder of Sierra's files (set CBR_SHARED_DATA)";
  const Mesh mesh = read_mesh(file);
  EXPECT_EQ(mesh.coordinates.rows(), 525);
  ASSERT_EQ(mesh.blocks.size(), 1U);
  EXPECT_EQ(mesh.blocks[0].type, ElementType::hex8);
  EXPECT_EQ(mesh.blocks[0].connectivity.rows(), 320);
  EXPECT_EQ(set_nodes(mesh, "nodelist_1").size(), 25U);
  EXPECT_EQ(set_nodes(mesh, "1"), set_nodes(mesh, "nodelist_1"));
}

}  // namespace
}  // namespace cbr::exodus_mesh_test
