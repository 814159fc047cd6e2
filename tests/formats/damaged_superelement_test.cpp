// SPDX-License-Identifier: GPL-3.0-or-later
// Every field of a superelement file damaged in turn: refused by name, never read, never a crash.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <functional>
#include <limits>
#include <random>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/superelement/superelement.hpp"
#include "tests/formats/raw_superelement.hpp"
#include "tests/formats/sample_superelement.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::damaged_superelement_test {
namespace {

using test::is_integer;
using test::of_other_rank;
using test::of_other_type;
using test::RawDataset;
using test::RawFile;
using test::TemporaryFolder;
using test::with_first;
using test::wrong_lengths;

constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();

std::string refusal(const std::filesystem::path& file) {
  return test::refusal_of([&] { read_superelement(file); });
}

class DamagedSuperelement : public testing::Test {
 protected:
  RawFile sample() const { return test::raw_superelement(test::sample_superelement()); }

  void expect_refused(const RawFile& raw, const std::string& field, const std::string& damage) {
    test::write_raw(raw, file);
    const std::string message = refusal(file);
    EXPECT_SAYS(message, file.string() + ": ") << field << " " << damage;
    EXPECT_SAYS(message, field) << field << " " << damage;
  }

  void expect_refused(const std::string& field, const std::string& damage,
                      const std::function<void(RawFile&)>& change) {
    RawFile raw = sample();
    change(raw);
    expect_refused(raw, field, damage);
  }

  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "s.cbr.h5";
};

bool is_optional_group(const std::string& name) { return name.rfind("/nodesets/", 0) == 0; }

// Of two fields that must fit each other either may be named; what they stand under is named for
// sure.
std::string named_for_length(const std::string& dataset) {
  for (const char* group : {"/interface/contact", "/interface/other side", "/nodes",
                            "/recovery/nodes", "/recovery/blocks"}) {
    if (dataset.rfind(group, 0) == 0) return group;
  }
  return dataset;
}

TEST_F(DamagedSuperelement, undamagedFileOfAnotherWriterIsRead) {
  test::write_raw(sample(), file);
  ASSERT_EQ(refusal(file), "no error");
  EXPECT_TRUE(test::identical(read_superelement(file), test::sample_superelement()));
}

TEST_F(DamagedSuperelement, everyDatasetMissing) {
  for (const auto& [name, values] : sample().datasets) {
    if (is_optional_group(name)) continue;
    expect_refused(name, "missing", [&, dataset = name](RawFile& raw) {
      raw.datasets.erase(dataset);
      raw.attributes.erase({dataset, "kind"});  // an attribute would make a group of that name
    });
  }
}

TEST_F(DamagedSuperelement, everyDatasetOfAnotherTypeRankOrLength) {
  for (const auto& [name, values] : sample().datasets) {
    RawFile raw = sample();
    raw.datasets[name] = of_other_type(values);
    expect_refused(raw, name, "of another type");
    raw.datasets[name] = of_other_rank(values);
    expect_refused(raw, name, "of another rank");
    if (is_optional_group(name)) continue;
    for (const auto& resized : wrong_lengths(values)) {
      raw.datasets[name] = resized;
      expect_refused(raw, named_for_length(name), "of another length");
    }
  }
}

TEST_F(DamagedSuperelement, everyNumberNotFiniteOrOutOfRange) {
  for (const auto& [name, values] : sample().datasets) {
    if (is_integer(values)) {
      // Ids and element numbers are the mesh's: any whole number.
      if (name.ends_with("id") || name.ends_with("/element")) continue;
      const std::string field =
          name == "/recovery/blocks/000000/connectivity" ? "/recovery/blocks" : name;
      for (const double entry : {-1.0, 1e6, 1e18, -1e18}) {
        expect_refused(field, "out of range", [&, dataset = name](RawFile& raw) {
          raw.datasets[dataset] = with_first(raw.datasets[dataset], entry);
        });
      }
    } else {
      for (const double entry : {nan, inf, -inf}) {
        expect_refused(name, "not finite", [&, dataset = name](RawFile& raw) {
          raw.datasets[dataset] = with_first(raw.datasets[dataset], entry);
        });
      }
    }
  }
}

TEST_F(DamagedSuperelement, everyAttributeMissingOrOfAnotherType) {
  for (const auto& [where, value] : sample().attributes) {
    const auto& [object, name] = where;
    if (object == "/provenance") continue;
    RawFile raw = sample();
    raw.attributes.erase(where);
    expect_refused(raw, "'" + name + "'", "missing");
    raw.attributes[where] = 0.5;
    expect_refused(raw, "'" + name + "'", "of another type");
  }
}

// The sample has 16 coordinates, of which 10 can be elastic modes.
TEST_F(DamagedSuperelement, spinCouplingsOfAnotherShapeOrNoNumbers) {
  const auto said_of = [&](const Matrix& P) {
    RawFile raw = sample();
    raw.datasets["/spin_couplings"] = P;
    test::write_raw(raw, file);
    return refusal(file);
  };
  const std::string field = file.string() + ": /spin_couplings: ";
  EXPECT_EQ(said_of(Matrix::Identity(30, 30)), "no error");
  EXPECT_EQ(said_of(Matrix::Identity(33, 33)),
            field +
                "wrong shape (33, 33), expected at most 30 rows, of the 16 modes without rigid "
                "ones");
  for (const auto& [rows, columns] : {std::pair<Index, Index>{6, 9}, {7, 7}, {9, 3}})
    EXPECT_EQ(said_of(Matrix::Zero(rows, columns)), field + "wrong shape (" + std::to_string(rows) +
                                                        ", " + std::to_string(columns) +
                                                        "), expected (3 m, 3 m) of m modes");
  for (const double entry : {nan, inf, -inf}) {
    Matrix P = Matrix::Identity(6, 6);
    P(1, 4) = P(4, 1) = entry;
    EXPECT_EQ(said_of(P), field + "not finite");
  }
  Matrix P = Matrix::Identity(6, 6);
  P(1, 4) = 1e-3;
  EXPECT_EQ(said_of(P), field + "not symmetric");
}

TEST_F(DamagedSuperelement, wrongFormatAndNewerMajorVersion) {
  const auto with = [&](const std::string& name, const std::string& value) {
    RawFile raw = sample();
    raw.attributes[{"/", name}] = value;
    return raw;
  };
  expect_refused(with("format", "cbr-results"),
                 "'format' is 'cbr-results', expected 'cbr-superelement'", "");
  expect_refused(with("format_version", "2.0"), "format_version 2.0 is newer", "");
  expect_refused(with("format_version", "10.3"), "format_version 10.3 is newer", "");
  for (const char* version : {"", "one", "0.9", "-1.0", "1x", "99999999999999.0"}) {
    expect_refused(with("format_version", version), "'format_version' is '", version);
  }
  expect_refused(with("basis", ""), "'basis'", "empty");
}

TEST_F(DamagedSuperelement, aNewerMinorVersionIsRead) {
  RawFile raw = sample();
  raw.attributes[{"/", "format_version"}] = std::string("1.17");
  raw.attributes[{"/provenance", "a number"}] = 4.0;
  raw.datasets["/novelty/values"] = Vector(Vector::Ones(3));
  test::write_raw(raw, file);
  ASSERT_EQ(refusal(file), "no error");
  EXPECT_TRUE(test::identical(read_superelement(file), test::sample_superelement()));
}

TEST_F(DamagedSuperelement, matricesThatBreakARule) {
  const auto change_matrix = [&](const std::string& name,
                                 const std::function<void(Matrix&)>& change) {
    expect_refused(name, "changed",
                   [&](RawFile& raw) { change(std::get<Matrix>(raw.datasets[name])); });
  };
  for (const char* name : {"/matrices/K_cc", "/matrices/M_cc", "/rigid_body/inertia"}) {
    change_matrix(name, [](Matrix& A) { A(2, 1) += 1e-8 * A.cwiseAbs().maxCoeff(); });
    change_matrix(name, [](Matrix& A) { A(0, 0) = -A.cwiseAbs().maxCoeff(); });
  }
  change_matrix("/rigid_body/inertia", [](Matrix& A) { A(0, 1) = A(1, 0) = 10; });
  // A matrix that is not the superelement's: the diagonal form no longer fits it.
  change_matrix("/diagonal/V", [](Matrix& V) { V.col(3) *= 1.001; });
  change_matrix("/diagonal/V", [](Matrix& V) { V.row(3).swap(V.row(4)); });
  change_matrix("/diagonal/V", [](Matrix& V) { V.transposeInPlace(); });
  expect_refused("/diagonal", "M_kc transposed in its memory", [](RawFile& raw) {
    auto& M_kc = std::get<Matrix>(raw.datasets["/matrices/M_kc"]);
    M_kc = Matrix(M_kc.transpose()).reshaped(M_kc.rows(), M_kc.cols()).eval();
  });
}

TEST_F(DamagedSuperelement, vectorsThatBreakARule) {
  const auto change = [&](const std::string& name, const auto& apply) {
    expect_refused(name, "changed", [&](RawFile& raw) { apply(raw.datasets[name]); });
  };
  change("/matrices/eigenvalues", [](RawDataset& values) { std::get<Vector>(values)(1) = -1e-3; });
  change("/diagonal/omega", [](RawDataset& values) { std::get<Vector>(values)(0) = -1; });
  change("/diagonal/omega", [](RawDataset& values) { std::get<Vector>(values).reverseInPlace(); });
  change("/diagonal/omega", [](RawDataset& values) { std::get<Vector>(values) *= 1.001; });
  change("/rigid_body/mass", [](RawDataset& values) { values = 0.0; });
  change("/rigid_body/mass", [](RawDataset& values) { values = -2.5; });
  // node 0, x twice
  change("/dofs/node", [](RawDataset& values) { std::get<std::vector<Index>>(values)[3] = 0; });
  change("/dofs/component",
         [](RawDataset& values) { std::get<std::vector<Index>>(values)[3] = 3; });
  change("/nodes/id", [](RawDataset& values) { std::get<std::vector<Index>>(values)[3] = 11; });
  change("/recovery/nodes/id",
         [](RawDataset& values) { std::get<std::vector<Index>>(values)[1] = 50; });
  change("/nodesets/clamp",
         [](RawDataset& values) { std::get<std::vector<Index>>(values)[0] = 3; });
  change("/interface/contact/side",
         [](RawDataset& values) { std::get<std::vector<Index>>(values)[0] = 7; });
  change("/interface/contact/faces",
         [](RawDataset& values) { std::get<IndexTable>(values)(0, 0) = 4; });
}

TEST_F(DamagedSuperelement, attributesThatBreakARule) {
  const auto with = [&](const std::string& object, const std::string& name,
                        const test::RawAttribute& value) {
    RawFile raw = sample();
    raw.attributes[{object, name}] = value;
    return raw;
  };
  expect_refused(with("/interface/contact/faces", "kind", "quad5"),
                 "'kind' is 'quad5', allowed: tri3, quad4, tri6, quad8, quad9", "");
  expect_refused(with("/interface/contact/faces", "kind", "tri3"),
                 "/interface/contact/faces: wrong shape (1, 4), expected (1, 3)", "");
  expect_refused(with("/recovery/blocks/000000", "type", "hex9"), "'type' is 'hex9'", "");
  expect_refused(with("/", "n_modes", Index{5}), "'n_modes' = 5", "");
  expect_refused(with("/", "n_interface", Index{-1}), "'n_interface' = -1", "");
}

TEST_F(DamagedSuperelement, setsThatAFileCannotName) {
  for (const char* name : {"", ".", "..", "a/b", "/", "a\nb"}) {
    Superelement s = test::sample_superelement();
    s.surfaces[0].name = name;
    EXPECT_THROW(write_superelement(s, file), InputError) << name;
    s = test::sample_superelement();
    s.nodesets[name] = {0};
    EXPECT_THROW(write_superelement(s, file), InputError) << name;
  }
  Superelement s = test::sample_superelement();
  s.surfaces[0].name = s.surfaces[1].name;
  EXPECT_THROW(write_superelement(s, file), InputError);
  EXPECT_EQ(folder.n_entries(), 0u);
}

TEST_F(DamagedSuperelement, filesThatAreNoSuperelement) {
  EXPECT_SAYS(refusal(file), "no such file");
  EXPECT_EQ(read_content_hash(file), "");
  EXPECT_SAYS(refusal(folder.path()), "is a directory");
  EXPECT_EQ(read_content_hash(folder.path()), "");
  EXPECT_SAYS(refusal("/dev/null"), "not a regular file");
  test::write_bytes(file, "");
  EXPECT_SAYS(refusal(file), "is empty");
  test::write_bytes(file, "materials: {}\n");
  EXPECT_SAYS(refusal(file), "not an HDF5 file");
  EXPECT_EQ(read_content_hash(file), "");
  Hdf5Writer writer(file);
  writer.write("/matrices/K_cc", Matrix(Matrix::Identity(2, 2)));
  writer.commit();
  EXPECT_SAYS(refusal(file), "not a superelement file");
  EXPECT_EQ(read_content_hash(file), "");
}

TEST_F(DamagedSuperelement, cutAnywhere) {
  write_superelement(test::sample_superelement(), file);
  const std::string bytes = test::bytes_of(file);
  for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 100) {
    test::write_bytes(file, bytes.substr(0, length));
    EXPECT_NE(refusal(file), "no error")
        << "cut after " << length << " of " << bytes.size() << " bytes";
  }
}

// A flipped bit may hit a number that stays valid; it must not do more than that.
TEST_F(DamagedSuperelement, anyByteChanged) {
  write_superelement(test::sample_superelement(), file);
  const std::string bytes = test::bytes_of(file);
  EXPECT_SAYS(bytes, "GCOL");
  std::mt19937 random(5);
  int refused = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::string damaged = bytes;
    // Every other time in the heap of strings: the one place without a checksum where the library
    // follows what it finds.
    const std::size_t begin = trial % 2 == 0 ? 0 : bytes.find("GCOL"),
                      length = trial % 2 == 0 ? bytes.size() : 500;
    for (int i = 0; i <= trial % 3; ++i)
      damaged[begin + random() % length] = static_cast<char>(random() % 256);
    test::write_bytes(file, damaged);
    if (refusal(file) != "no error") ++refused;
  }
  EXPECT_GT(refused, 60);
  // handles left open, which lsan.supp hides
  EXPECT_EQ(H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL), 0);
}

}  // namespace
}  // namespace cbr::damaged_superelement_test
