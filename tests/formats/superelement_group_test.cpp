// SPDX-License-Identifier: GPL-3.0-or-later
// Groups of superelements: their file, whole and damaged, and the sum that join() makes of them.
#include "common/superelement/superelement_group.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "common/base/error.hpp"
#include "tests/formats/raw_superelement.hpp"
#include "tests/formats/sample_superelement.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::superelement_group_test {
namespace {

using test::RawFile;
using test::sample_group;
using test::TemporaryFolder;

std::string refusal(const std::filesystem::path& file) {
  return test::refusal_of([&] { read_superelement_group(file); });
}

class SuperelementGroupFile : public testing::Test {
 protected:
  void expect_refused(const RawFile& raw, const std::string& field, const std::string& damage) {
    test::write_raw(raw, file);
    const std::string message = refusal(file);
    EXPECT_SAYS(message, file.string() + ": ") << field << " " << damage;
    EXPECT_SAYS(message, field) << field << " " << damage;
  }

  void expect_refused(const std::string& field,
                      const std::function<void(SuperelementGroup&)>& change) {
    SuperelementGroup group = sample_group();
    change(group);
    expect_refused(test::raw_group(group), field, "changed");
    EXPECT_THROW(write_superelement_group(group, folder / "other.h5"), InputError) << field;
    EXPECT_EQ(folder.n_entries(), 1u);
  }

  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "group.cbr.h5";
};

TEST_F(SuperelementGroupFile, readsBackWhatWasWritten) {
  for (const bool optional_parts : {true, false}) {
    SuperelementGroup written = sample_group();
    if (!optional_parts) {
      written.omega.resize(0);
      written.V.resize(0, 0);
      for (auto& s : written.domains) {
        s.recovery.clear();
        s.nodesets.clear();
      }
    }
    write_superelement_group(written, file);
    EXPECT_TRUE(test::identical(read_superelement_group(file), written)) << optional_parts;
    EXPECT_EQ(read_content_hash(file), written.content_hash);
    EXPECT_TRUE(is_superelement_group(file));
    EXPECT_EQ(folder.n_entries(), 1u);
  }
}

TEST_F(SuperelementGroupFile, thatAnotherWriterSpeltOutIsRead) {
  test::write_raw(test::raw_group(sample_group()), file);
  ASSERT_EQ(refusal(file), "no error");
  EXPECT_TRUE(test::identical(read_superelement_group(file), sample_group()));
}

TEST_F(SuperelementGroupFile, partsThatAreNotAskedForAreNotRead) {
  write_superelement_group(sample_group(), file);
  const SuperelementGroup bare =
      read_superelement_group(file, {.matrices = false, .diagonal = false, .recovery = false});
  EXPECT_FALSE(bare.has_diagonal_form());
  for (const auto& s : bare.domains)
    EXPECT_EQ(s.K_cc.size() + s.M_cc.size() + s.M_kc.size() + std::ssize(s.recovery), 0);
  const Superelement whole = join(bare);
  EXPECT_EQ(whole.n(), join(sample_group()).n());
  EXPECT_EQ(whole.K_cc.size(), 0);
  const Superelement diagonal =
      join(read_superelement_group(file, {.matrices = false, .diagonal = true, .recovery = false}));
  EXPECT_EQ(diagonal.V, sample_group().V);
}

TEST_F(SuperelementGroupFile, sameContentsSameBytes) {
  write_superelement_group(sample_group(), file);
  write_superelement_group(sample_group(), folder / "b.h5");
  EXPECT_EQ(test::bytes_of(file), test::bytes_of(folder / "b.h5"));
}

TEST_F(SuperelementGroupFile, eachReaderNamesTheOthersFile) {
  write_superelement_group(sample_group(), file);
  EXPECT_SAYS(test::refusal_of([&] { read_superelement(file); }),
              "domains of a decomposed component");
  write_superelement(test::sample_superelement(), file);
  EXPECT_SAYS(refusal(file), "it holds one superelement");
  EXPECT_FALSE(is_superelement_group(file));
  EXPECT_FALSE(is_superelement_group(folder / "nothing"));
}

TEST_F(SuperelementGroupFile, everyDatasetMissingOrOfAnotherTypeOrRank) {
  const RawFile whole = test::raw_group(sample_group());
  for (const auto& [name, values] : whole.datasets) {
    RawFile raw = whole;
    raw.datasets[name] = test::of_other_type(values);
    expect_refused(raw, name, "of another type");
    raw.datasets[name] = test::of_other_rank(values);
    expect_refused(raw, name, "of another rank");
    if (name.find("/nodesets/") != std::string::npos) continue;
    raw.datasets.erase(name);
    raw.attributes.erase({name, "kind"});
    expect_refused(raw, name, "missing");
  }
}

TEST_F(SuperelementGroupFile, everyAttributeMissingOrOfAnotherType) {
  const RawFile whole = test::raw_group(sample_group());
  for (const auto& [where, value] : whole.attributes) {
    if (where.first.ends_with("/provenance")) continue;
    RawFile raw = whole;
    raw.attributes.erase(where);
    expect_refused(raw, "'" + where.second + "'", "missing");
    raw.attributes[where] = 0.5;
    expect_refused(raw, "'" + where.second + "'", "of another type");
  }
}

TEST_F(SuperelementGroupFile, numbersThatAreNotOfTheDomains) {
  RawFile raw = test::raw_group(sample_group());
  for (const auto& [name, wrong] :
       std::map<std::string, Index>{{"n_domains", 2}, {"n_modes", 4}, {"n_interface", 36}}) {
    RawFile damaged = raw;
    damaged.attributes[{"/", name}] = wrong;
    expect_refused(damaged, "'" + name + "' = " + std::to_string(wrong), "");
  }
  RawFile newer = raw;
  newer.attributes[{"/", "format_version"}] = std::string("2.0");
  expect_refused(newer, "format_version 2.0 is newer", "");
  RawFile no_domains = raw;
  std::erase_if(no_domains.datasets,
                [](const auto& item) { return item.first.starts_with("/domains/"); });
  std::erase_if(no_domains.attributes,
                [](const auto& item) { return item.first.first.starts_with("/domains/"); });
  expect_refused(no_domains, "'n_domains' = 3", "");
  no_domains.attributes[{"/", "n_domains"}] = Index{0};
  expect_refused(no_domains, "'n_domains'", "");
}

TEST_F(SuperelementGroupFile, domainsThatDoNotFitEachOther) {
  expect_refused("/domains/3/nodes/coordinates: node id 1 is elsewhere in /domains/1",
                 [](SuperelementGroup& group) { group.domains[2].coordinates(1, 0) += 1e-3; });
  expect_refused("/rigid_body/mass",
                 [](SuperelementGroup& group) { group.rigid_body.mass *= 1.001; });
  expect_refused("'basis'", [](SuperelementGroup& group) { group.domains[1].basis = "rubin"; });
  expect_refused("/interface/contact", [](SuperelementGroup& group) {
    Surface& surface = group.domains[1].surfaces[0];
    surface.kind = FaceKind::quad8;
    surface.faces = IndexTable::Zero(1, 8);
  });
  expect_refused("/domains/2/dofs/node", [](SuperelementGroup& group) {
    Superelement& s = group.domains[1];
    s.dof_node.pop_back();
    s.dof_component.pop_back();
    s.K_cc = Matrix(s.K_cc.topLeftCorner(11, 11));
    s.M_cc = Matrix(s.M_cc.topLeftCorner(11, 11));
    s.M_kc = Matrix(s.M_kc.leftCols(11));
    s.recovery.clear();
  });
  expect_refused("/diagonal/omega", [](SuperelementGroup& group) { group.omega *= 1.001; });
  expect_refused("/diagonal/V",
                 [](SuperelementGroup& group) { group.V.row(14).swap(group.V.row(20)); });
  expect_refused("/diagonal", [](SuperelementGroup& group) { group.domains[1].K_cc *= 2; });
}

TEST_F(SuperelementGroupFile, anyByteChanged) {
  write_superelement_group(sample_group(), file);
  const std::string bytes = test::bytes_of(file);
  std::mt19937 random(7);
  int refused = 0;
  for (int trial = 0; trial < 75; ++trial) {
    std::string damaged = bytes;
    for (int i = 0; i <= trial % 3; ++i)
      damaged[random() % bytes.size()] = static_cast<char>(random() % 256);
    test::write_bytes(file, damaged);
    if (refusal(file) != "no error") ++refused;
  }
  EXPECT_GT(refused, 12);
  for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 50) {
    test::write_bytes(file, bytes.substr(0, length));
    EXPECT_NE(refusal(file), "no error")
        << "cut after " << length << " of " << bytes.size() << " bytes";
  }
}

// The whole by its definition: x^T K x and x^T M x are the sums over the domains, each with its
// share of x.
TEST(Join, isTheSumOfTheDomains) {
  const SuperelementGroup group = sample_group();
  const JoinedNodes nodes = join_nodes(group);
  const Superelement whole = join(group);
  EXPECT_EQ(nodes.node_ids, (std::vector<Index>{0, 1, 2, 10, 11, 12, 20, 21}));
  ASSERT_EQ(whole.k(), 12);
  ASSERT_EQ(whole.c(), 24);
  const Matrix K = reduced_stiffness(whole), M = reduced_mass(whole);
  std::srand(3);
  for (int trial = 0; trial < 5; ++trial) {
    const Vector x = Vector::Random(whole.n());
    double stiffness = 0, mass = 0;
    for (std::size_t d = 0; d < 3; ++d) {
      const Superelement& s = group.domains[d];
      Vector y(s.n());
      y.head(4) = x.segment(4 * static_cast<Index>(d), 4);
      for (Index i = 0; i < s.c(); ++i) {
        const Index id = s.node_ids[i / 3];
        const auto at =
            std::find(whole.node_ids.begin(), whole.node_ids.end(), id) - whole.node_ids.begin();
        y(4 + i) = x(12 + 3 * at + i % 3);
      }
      stiffness += y.dot(reduced_stiffness(s) * y);
      mass += y.dot(reduced_mass(s) * y);
    }
    EXPECT_NEAR(x.dot(K * x), stiffness, 1e-12 * K.norm());
    EXPECT_NEAR(x.dot(M * x), mass, 1e-12 * M.norm());
  }
}

TEST(Join, keepsTheFacesAndNodesOfAllDomains) {
  const SuperelementGroup group = sample_group();
  const Superelement whole = join(group);
  ASSERT_EQ(whole.surfaces.size(), 2u);
  EXPECT_EQ(whole.surfaces[0].name, "contact");
  EXPECT_EQ(whole.surfaces[0].element, (std::vector<Index>{7, 17, 27}));
  EXPECT_EQ(whole.surfaces[1].n_faces(), 4);
  const auto ids = [&](const auto& nodes) {
    std::vector<Index> found;
    for (const Index node : nodes) found.push_back(whole.node_ids[node]);
    return found;
  };
  EXPECT_EQ(ids(whole.surfaces[0].faces.row(2)), (std::vector<Index>{2, 1, 11, 12}));
  EXPECT_EQ(ids(whole.nodesets.at("clamp")), (std::vector<Index>{1, 10, 11, 12, 20}));
  for (std::size_t i = 0; i < whole.node_ids.size(); ++i) {
    const Index id = whole.node_ids[i];
    EXPECT_EQ(Vector3(whole.coordinates.row(static_cast<Index>(i))),
              Vector3(static_cast<double>(id / 10), static_cast<double>(id % 10), 0.25));
  }
  EXPECT_EQ(whole.rigid_body.mass, 6);
}

TEST(Join, trianglesInOneDomainAndQuadsInAnotherAreQuads) {
  SuperelementGroup group = sample_group();
  group.domains[1].surfaces[0] = group.domains[0].surfaces[1];
  group.domains[1].surfaces[0].name = "contact";
  const Superelement whole = join(group);
  EXPECT_EQ(whole.surfaces[0].kind, FaceKind::quad4);
  ASSERT_EQ(whole.surfaces[0].n_faces(), 4);
  EXPECT_EQ(whole.surfaces[0].faces(1, 2), whole.surfaces[0].faces(1, 3));
  EXPECT_NE(whole.surfaces[0].faces(0, 2), whole.surfaces[0].faces(0, 3));
}

}  // namespace
}  // namespace cbr::superelement_group_test
