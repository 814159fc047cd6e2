// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/hdf5_file.hpp"

#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::hdf5_file_test {
namespace {

using test::TemporaryFolder;

TEST(Hdf5File, everyTypeComesBack) {
  const TemporaryFolder folder;
  const Vector vector = Vector::Random(7);
  const Points points = Points::Random(5, 3);
  const IndexTable table = IndexTable::Random(4, 6);
  Hdf5Writer writer(folder / "f.h5");
  writer.write("/a/b/c/scalar", 2.5);
  writer.write("/vector", vector);
  writer.write("/std", std::vector<double>{1, 2.5});
  writer.write("/points", points);
  writer.write("/a/table", table);
  writer.write("/a/indices", std::vector<Index>{-1, Index{1} << 60});
  writer.write("/a/ints", std::vector<int>{-3, 4});
  writer.write("/none", Vector());
  writer.write("/no rows", Matrix(0, 4));
  writer.attribute("/a", "text", std::string("\xc3\xa9t\xc3\xa9"));
  writer.attribute("/a", "empty", std::string());
  writer.attribute("/new group", "number", Index{-5});
  writer.attribute("/vector", "factor", 0.5);
  writer.commit();
  const Hdf5Reader reader(folder / "f.h5");
  EXPECT_EQ(reader.read_scalar("/a/b/c/scalar"), 2.5);
  EXPECT_EQ(reader.read_vector("/vector"), vector);
  EXPECT_EQ(reader.read_vector("/std"), Vector((Vector(2) << 1, 2.5).finished()));
  EXPECT_EQ(reader.read_points("/points"), points);
  EXPECT_EQ(reader.read_index_table("/a/table"), table);
  EXPECT_EQ(reader.read_indices("/a/indices"), (std::vector<Index>{-1, Index{1} << 60}));
  EXPECT_EQ(reader.read_indices("/a/ints"), (std::vector<Index>{-3, 4}));
  EXPECT_EQ(reader.read_vector("/none").size(), 0);
  EXPECT_EQ(reader.read_matrix("/no rows").cols(), 4);
  EXPECT_EQ(reader.read_string("/a", "text"), "\xc3\xa9t\xc3\xa9");
  EXPECT_EQ(reader.read_string("/a", "empty"), "");
  EXPECT_EQ(reader.read_index("/new group", "number"), -5);
  EXPECT_EQ(reader.children("/a"), (std::vector<std::string>{"b", "indices", "ints", "table"}));
  EXPECT_EQ(reader.texts("/a"),
            (std::map<std::string, std::string>{{"empty", ""}, {"text", "\xc3\xa9t\xc3\xa9"}}));
  EXPECT_TRUE(reader.texts("/vector").empty() && reader.texts("/missing").empty());
  EXPECT_EQ(reader.shape("/points"), (std::vector<Index>{5, 3}));
  EXPECT_TRUE(reader.has("/") && reader.has("/a/b") && reader.has("/vector"));
  EXPECT_FALSE(reader.has("/x") || reader.has("/x/y") || reader.has("/vector/y"));
  EXPECT_FALSE(reader.has_attribute("/a", "number"));
}

// Larger than the panels in which a column-major matrix is turned into rows.
TEST(Hdf5File, matricesOfEveryShapeComeBack) {
  const TemporaryFolder folder;
  for (const auto& [rows, columns] :
       {std::pair<Index, Index>{1, 1}, {3, 5}, {5, 3}, {2100, 2003}, {4, 300000}, {1, 2500000}}) {
    const Matrix A = Matrix::Random(rows, columns);
    Hdf5Writer writer(folder / "f.h5");
    writer.write("/A", A);
    writer.commit();
    EXPECT_EQ(Hdf5Reader(folder / "f.h5").read_matrix("/A"), A) << rows << " x " << columns;
  }
}

// One bit of one number changed in the file itself, behind the library's back; panels of large
// matrices as well.
TEST(Hdf5File, numbersThatAreNotThoseThatWereWrittenAreRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "f.h5";
  const Vector vector = Vector::Random(7);
  const Matrix matrix = Matrix::Random(3, 700000);
  const std::vector<Index> indices{3, Index{1} << 60, 12345678901};
  Hdf5Writer writer(file);
  writer.add_checksums();
  writer.write("/scalar", 0.123456789);
  writer.write("/vector", vector);
  writer.write("/matrix", matrix);
  writer.write("/rows", RowMatrix(matrix));
  writer.write("/points", Points(Points::Constant(4, 3, 0.987654321)));
  writer.write("/indices", indices);
  writer.write("/ints", std::vector<int>{98765432, 2});
  writer.write("/table", IndexTable(IndexTable::Constant(2, 4, 192837465)));
  writer.write("/none", Vector());
  writer.write("/no rows", Matrix(0, 4));
  writer.commit();
  const auto read_all = [&] {
    const Hdf5Reader reader(file);
    reader.read_scalar("/scalar");
    reader.read_vector("/vector");
    reader.read_matrix("/matrix");
    reader.read_matrix("/rows");
    reader.read_row_matrix("/matrix");
    reader.read_row_matrix("/rows");
    reader.read_points("/points");
    reader.read_indices("/indices");
    reader.read_indices("/ints");
    reader.read_index_table("/table");
    reader.read_vector("/none");
    reader.read_matrix("/no rows");
  };
  EXPECT_NO_THROW(read_all());
  EXPECT_EQ(Hdf5Reader(file).read_index("/matrix", "checksum"),
            Hdf5Reader(file).read_index("/rows", "checksum"));
  const std::string bytes = test::bytes_of(file);
  const auto bytes_of_value = [](const auto& value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const std::pair<std::string, std::string> numbers[] = {
      {"/scalar", bytes_of_value(0.123456789)},       {"/vector", bytes_of_value(vector(6))},
      {"/matrix", bytes_of_value(matrix(2, 699999))}, {"/points", bytes_of_value(0.987654321)},
      {"/indices", bytes_of_value(indices[2])},       {"/ints", bytes_of_value(Index{98765432})},
      {"/table", bytes_of_value(Index{192837465})}};
  for (const auto& [dataset, number] : numbers) {
    const std::size_t at = bytes.find(number);
    ASSERT_NE(at, std::string::npos) << dataset;
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);  // the last bit of 53
    test::write_bytes(file, damaged);
    EXPECT_THROW(Hdf5Reader(file).compare_checksums("/"), InputError) << dataset;
    const std::string message = test::refusal_of([&] { read_all(); });
    EXPECT_SAYS(message, file.string() + ": " + dataset + ": its numbers are not those");
  }
}

TEST(Hdf5File, textsThatAreNotThoseThatWereWrittenAreRefused) {
  const TemporaryFolder folder;
  const auto file = folder / "f.h5";
  Hdf5Writer writer(file);
  writer.start("cbr-test", "1.0", "test");
  writer.attribute("/group", "of the material", std::string("steel, 7850 kg/m^3"));
  writer.attribute("/group", "number", 2.0);
  writer.attribute("/group", "more", std::string("words"));
  writer.commit();
  const std::string bytes = test::bytes_of(file);
  const auto damaged = [&](const std::string& text) {
    std::string changed = bytes;
    const std::size_t at = changed.find(text);
    EXPECT_NE(at, std::string::npos) << text;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    test::write_bytes(file, changed);
    return Hdf5Reader(file);
  };
  EXPECT_NO_THROW(Hdf5Reader(file).compare_checksums("/"));
  EXPECT_EQ(Hdf5Reader(file).texts("/group").size(), 2U);
  for (const char* text : {"7850", "words", "cbr-test"}) {
    const Hdf5Reader reader(damaged(text));
    EXPECT_THROW(reader.compare_checksums("/"), InputError) << text;
  }
  const Hdf5Reader reader(damaged("7850"));
  EXPECT_EQ(reader.read_string("/", "format"), "cbr-test");
  const std::string message = test::refusal_of([&] { reader.read_string("/group", "more"); });
  EXPECT_EQ(message.find(file.string() + ": /group: its texts are not those"), 0U) << message;
}

TEST(Hdf5File, comparesAllChecksumsOfAGroup) {
  const TemporaryFolder folder;
  Hdf5Writer writer(folder / "f.h5");
  writer.write("/old", 1.0);
  writer.add_checksums();
  writer.write("/steps/0/u", Vector(Vector::Random(3)));
  writer.write("/steps/0/ids", std::vector<Index>{4, 5});
  const Index first = writer.digest();
  writer.link("/steps/0/u", "/steps/1/u");
  writer.write("/steps/1/table", IndexTable(IndexTable::Random(2, 3)));
  const Index all = writer.digest();
  writer.commit();
  const Hdf5Reader reader(folder / "f.h5");
  const ComparedChecksums found = reader.compare_checksums("/"),
                          begun = reader.compare_checksums("/steps/0");
  EXPECT_EQ(found.datasets, 3);
  EXPECT_EQ(found.without, 1);
  EXPECT_EQ(found.digest, all);
  EXPECT_EQ(begun.datasets, 2);
  EXPECT_EQ(begun.digest, first);
  EXPECT_EQ(begun.digest ^ reader.compare_checksums("/steps/1").digest, all);
  Hdf5Writer more(folder / "more.h5", folder / "f.h5");
  more.add_checksums(all);
  more.write("/steps/2/u", Vector(Vector::Random(3)));
  const Index with_more = more.digest();
  more.commit();
  EXPECT_EQ(Hdf5Reader(folder / "more.h5").compare_checksums("/").digest, with_more);
}

// Larger than what is looked at whole for damaged strings; strings at the beginning, in the middle
// and at the end.
TEST(Hdf5File, stringsOfALargeFileComeBack) {
  const TemporaryFolder folder;
  Hdf5Writer writer(folder / "f.h5");
  const std::string text(1000, 'x');
  for (int i = 0; i < 12; ++i) {
    writer.attribute("/group " + std::to_string(i), "text", text);
    writer.write("/group " + std::to_string(i) + "/A", Matrix(Matrix::Zero(1000, 700)));
  }
  writer.commit();
  const Hdf5Reader reader(folder / "f.h5");
  for (int i = 0; i < 12; ++i)
    EXPECT_EQ(reader.read_string("/group " + std::to_string(i), "text"), text);
}

TEST(Hdf5File, wrongQuestionsAreRefused) {
  const TemporaryFolder folder;
  Hdf5Writer writer(folder / "f.h5");
  writer.write("/group/vector", Vector(Vector::Ones(3)));
  writer.write("/ints", std::vector<Index>{1});
  writer.attribute("/group", "text", std::string("word"));
  writer.commit();
  const Hdf5Reader reader(folder / "f.h5");
  EXPECT_THROW(reader.read_vector("/group"), InputError);
  EXPECT_THROW(reader.read_vector("/missing"), InputError);
  EXPECT_THROW(reader.read_vector("/group/vector/below"), InputError);
  EXPECT_THROW(reader.read_vector("/ints"), InputError);
  EXPECT_THROW(reader.read_indices("/group/vector"), InputError);
  EXPECT_THROW(reader.read_matrix("/group/vector"), InputError);
  EXPECT_THROW(reader.read_scalar("/group/vector"), InputError);
  EXPECT_THROW(reader.children("/group/vector"), InputError);
  EXPECT_THROW(reader.children("/missing"), InputError);
  EXPECT_THROW(reader.read_string("/group", "missing"), InputError);
  EXPECT_THROW(reader.read_index("/group", "text"), InputError);
}

}  // namespace
}  // namespace cbr::hdf5_file_test
