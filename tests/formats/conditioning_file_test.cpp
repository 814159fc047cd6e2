// SPDX-License-Identifier: GPL-3.0-or-later
// /conditioning of superelements and groups: what was known comes back, what was not is not there,
// what cannot be is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "tests/formats/raw_superelement.hpp"
#include "tests/formats/sample_superelement.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::conditioning_file_test {
namespace {

using test::RawFile;
using test::TemporaryFolder;

Conditioning all_known() {
  Conditioning c;
  c.K_II = {1e6, 2e3};
  c.mass = {30, 20};
  c.smallest_pivot = 0.125;
  c.modes.orthogonality = 1e-15;
  c.modes.residual = 2e-14;
  c.rigid = 1e-16;
  c.reduced_rigid = 3e-16;
  c.softest = 0.5;
  c.lowest_omega = 3;
  c.largest_omega = 700;
  c.n_zero = 7;
  c.n_rigid = 6;
  c.counts = "4 below 12 Hz";
  c.weakest = "node 5 in x";
  c.rigid_node = "node 6";
  c.loose_node = "node 7";
  return c;
}

// In the order of docs/formats.md
std::vector<double> figures(const Conditioning& c) {
  return {c.K_II.plain,
          c.K_II.scaled,
          c.smallest_pivot,
          c.mass.plain,
          c.mass.scaled,
          c.modes.orthogonality,
          c.modes.residual,
          c.rigid,
          c.reduced_rigid,
          c.softest,
          c.lowest_omega,
          c.largest_omega,
          static_cast<double>(c.n_zero),
          static_cast<double>(c.n_rigid)};
}
std::vector<std::string> words(const Conditioning& c) {
  return {c.counts, c.weakest, c.rigid_node, c.loose_node};
}

constexpr const char* datasets[] = {"K_II",          "K_II_scaled",         "smallest_pivot",
                                    "reduced_mass",  "reduced_mass_scaled", "mode_orthogonality",
                                    "mode_residual", "rigid_forces",        "reduced_rigid_forces",
                                    "softest",       "lowest_omega",        "largest_omega"};

TEST(ConditioningFile, whatIsKnownIsKept) {
  const TemporaryFolder folder;
  Superelement written = test::sample_superelement();
  written.conditioning = all_known();
  write_superelement(written, folder / "s.h5");
  const Hdf5Reader file(folder / "s.h5");
  EXPECT_EQ(file.read_string("/", "format_version"), "1.16");
  for (const char* name : datasets)
    EXPECT_TRUE(file.has(std::string("/conditioning/") + name)) << name;
  for (const bool matrices : {true, false}) {
    const Superelement read = read_superelement(folder / "s.h5", {matrices, matrices, matrices});
    ASSERT_TRUE(read.conditioning);
    EXPECT_EQ(figures(*read.conditioning), figures(all_known()));
    EXPECT_EQ(words(*read.conditioning), words(all_known()));
  }
}

TEST(ConditioningFile, whatIsNotKnownIsNotThere) {
  const TemporaryFolder folder;
  Superelement written = test::sample_superelement();
  written.conditioning.emplace();
  // not positive definite: known
  written.conditioning->mass.scaled = std::numeric_limits<double>::infinity();
  write_superelement(written, folder / "s.h5");
  const Hdf5Reader file(folder / "s.h5");
  EXPECT_EQ(file.children("/conditioning"), std::vector<std::string>{"reduced_mass_scaled"});
  EXPECT_TRUE(file.texts("/conditioning").empty());
  const Superelement read = read_superelement(folder / "s.h5");
  ASSERT_TRUE(read.conditioning);
  const Conditioning& c = *read.conditioning;
  EXPECT_TRUE(std::isinf(c.mass.scaled));
  for (const double value : {c.K_II.plain, c.K_II.scaled, c.smallest_pivot, c.mass.plain, c.rigid,
                             c.reduced_rigid, c.softest})
    EXPECT_TRUE(std::isnan(value)) << value;
  EXPECT_FALSE(c.knows_modes() || c.knows_frequencies() || c.rho_res);
  EXPECT_EQ(words(c), std::vector<std::string>(4));
  write_superelement(test::sample_superelement(), folder / "none.h5");
  EXPECT_FALSE(read_superelement(folder / "none.h5").conditioning);
}

TEST(ConditioningFile, groupsAndTheirDomainsHaveTheirOwn) {
  const TemporaryFolder folder;
  SuperelementGroup group = test::sample_group();
  write_superelement_group(group, folder / "none.h5");
  EXPECT_FALSE(read_superelement_group(folder / "none.h5").conditioning);
  group.conditioning = all_known();
  group.conditioning->rho_res = Vector3(0.25, 0.5, 0.125);
  group.domains[1].conditioning.emplace().rigid = 1e-15;
  write_superelement_group(group, folder / "g.h5");
  EXPECT_EQ(Hdf5Reader(folder / "g.h5").read_string("/", "format_version"), "1.3");
  const SuperelementGroup read = read_superelement_group(folder / "g.h5");
  ASSERT_TRUE(read.conditioning && read.domains[1].conditioning);
  EXPECT_EQ(figures(*read.conditioning), figures(all_known()));
  EXPECT_EQ(read.conditioning->rho_res, Vector3(0.25, 0.5, 0.125));
  EXPECT_EQ(read.domains[1].conditioning->rigid, 1e-15);
  EXPECT_FALSE(read.domains[0].conditioning);
}

class DamagedConditioning : public testing::Test {
 protected:
  void SetUp() override {
    raw = test::raw_superelement(test::sample_superelement());
    for (std::size_t i = 0; i < std::size(datasets); ++i)
      raw.datasets[group + datasets[i]] = figures(all_known())[i];
    raw.attributes[{"/conditioning", "n_zero"}] = Index{7};
    raw.attributes[{"/conditioning", "n_rigid"}] = Index{6};
  }

  std::string refusal(const RawFile& changed) {
    test::write_raw(changed, folder / "s.h5");
    return test::refusal_of([&] { read_superelement(folder / "s.h5", {false, false, false}); });
  }

  void expect_refused(const std::string& name, const test::RawDataset& value) {
    RawFile changed = raw;
    changed.datasets[group + name] = value;
    EXPECT_SAYS(refusal(changed), (folder / "s.h5").string() + ": /conditioning", name) << name;
  }

  const TemporaryFolder folder;
  const std::string group = "/conditioning/";
  RawFile raw;
};

TEST_F(DamagedConditioning, everyFigureMayBeMissing) {
  EXPECT_EQ(refusal(raw), "no error");
  for (const char* name : datasets) {
    RawFile changed = raw;
    changed.datasets.erase(group + name);
    EXPECT_EQ(refusal(changed), "no error") << name;
  }
}

TEST_F(DamagedConditioning, everyFigureIsRefusedByName) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   inf = std::numeric_limits<double>::infinity();
  for (const std::string name : datasets) {
    for (const double value : {nan, -inf, -1.0}) expect_refused(name, value);
    expect_refused(name, Vector(Vector::Ones(2)));
    expect_refused(name, std::vector<Index>{1});
    const bool is_condition_number = name.starts_with("K_II") || name.starts_with("reduced_mass");
    expect_refused(name, is_condition_number ? 0.5 : inf);
  }
  expect_refused("lowest_omega", 701.0);
  expect_refused("rho_res", Vector(Vector3(0.1, nan, 0.1)));
  expect_refused("rho_res", Vector(Vector3(0.1, 0.1, 1e300)));
  expect_refused("rho_res", Vector(Vector::Ones(2)));
}

TEST_F(DamagedConditioning, countsOfFrequenciesAreThoseOfTheCoordinates) {
  for (const std::string name : {"n_zero", "n_rigid"}) {
    for (const Index value : {-1, 17}) {
      RawFile changed = raw;
      changed.attributes[{"/conditioning", name}] = value;
      EXPECT_SAYS(refusal(changed), "'" + name + "'");
    }
    RawFile changed = raw;
    changed.attributes.erase({"/conditioning", name});
    EXPECT_SAYS(refusal(changed), "'" + name + "' missing");
  }
}

}  // namespace
}  // namespace cbr::conditioning_file_test
