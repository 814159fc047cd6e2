// SPDX-License-Identifier: GPL-3.0-or-later
#include <malloc.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <string_view>

#include "common/base/checksum.hpp"
#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/hdf5_handle.hpp"

namespace cbr {

namespace fs = std::filesystem;
using hdf5::Handle;

namespace {

herr_t visit_attribute(hid_t owner, const char* name, const H5A_info_t*, void*) {
  const Handle attribute(H5Aopen(owner, name, H5P_DEFAULT), H5Aclose);
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  const std::size_t size = H5Tget_size(type);
  if (H5Sget_simple_extent_npoints(space) != 1 || size == 0 || size > (std::size_t{1} << 20))
    return 0;
  std::vector<char> value(size);
  if (H5Aread(attribute, type, value.data()) >= 0)
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, value.data());
  return 0;
}

// Contiguous data are only bytes; chunks and small datasets in headers need structures of their
// own.
void visit_dataset(hid_t dataset) {
  const Handle type(H5Dget_type(dataset), H5Tclose), space(H5Dget_space(dataset), H5Sclose),
      properties(H5Dget_create_plist(dataset), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(properties);
  if (layout != H5D_CHUNKED && layout != H5D_COMPACT) return;
  const bool real = H5Tget_class(type) == H5T_FLOAT;
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  const double most = 1032.0 * static_cast<double>(H5Dget_storage_size(dataset));
  if ((!real && H5Tget_class(type) != H5T_INTEGER) || n <= 0 || static_cast<double>(n) > most)
    return;
  std::vector<double> values(n);
  H5Dread(dataset, real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT,
          values.data());
}

template <typename Info>
herr_t collect_name(hid_t, const char* name, const Info*, void* list) {
  static_cast<std::vector<std::string>*>(list)->emplace_back(name);
  return 0;
}

herr_t collect_hard_link(hid_t, const char* name, const H5L_info_t* info, void* list) {
  if (info->type == H5L_TYPE_HARD) static_cast<std::vector<std::string>*>(list)->emplace_back(name);
  return 0;
}

// Group by group as children() does, and on after unreadable ones: H5Ovisit would stop there. Each
// object once: damage may make circles. seen: addresses.
void visit_object(hid_t object, std::set<haddr_t>& seen) {
  H5O_info_t info;
  if (H5Oget_info2(object, &info, H5O_INFO_BASIC) < 0 || !seen.insert(info.addr).second) return;
  H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit_attribute, nullptr);
  if (H5Iget_type(object) == H5I_DATASET) visit_dataset(object);
  if (H5Iget_type(object) != H5I_GROUP) return;
  std::vector<std::string> names;
  H5Literate(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_hard_link, &names);
  for (const std::string& name : names) {
    const Handle child(H5Oopen(object, name.c_str(), H5P_DEFAULT), H5Oclose);
    if (child.ok()) visit_object(child, seen);
  }
}

Handle open_read_only(const fs::path& path) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
#if H5_VERSION_GE(1, 10, 7)
  // a file is renamed when whole, never changed: locks only fail on network disks
  H5Pset_file_locking(access, false, true);
#endif
  return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose};
}

// Of files that users take for those of these programs, by their first bytes and names.
std::string cure(const fs::path& path) {
  char start[3] = {};
  std::ifstream(path, std::ios::binary).read(start, 3);
  const std::string suffix = path.extension().string();
  const bool is_netcdf = std::string_view(start, 3) == "CDF";
  if (is_netcdf && suffix != ".exo" && suffix != ".e" && suffix != ".g")
    return ": a superelement of Sierra is read by cbr-reduce --import sierra";
  for (const char* mesh : {".msh", ".exo", ".e", ".g", ".inp", ".bdf", ".unv", ".yaml", ".yml"})
    if (suffix == mesh)
      return ": give the superelement (.cbr.h5) that a mesh or a scene is reduced to";
  return "";
}

// All that the reader may come to, or attributes of the root; for a process of its own. The library
// frees pointers that it has not set where a group's table is damaged. Memory that is filled shows
// it, whatever was there.
void visit(const fs::path& path, Hdf5Reader::Look look) {
  mallopt(M_PERTURB, 0x5a);
  const Handle file = open_read_only(path);
  if (!file.ok()) return;
  const Handle root(H5Oopen(file, "/", H5P_DEFAULT), H5Oclose);
  if (!root.ok()) return;
  if (look == Hdf5Reader::Look::root_attributes) {
    H5Aiterate2(root, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit_attribute, nullptr);
    return;
  }
  std::set<haddr_t> seen;
  visit_object(root, seen);
}

}  // namespace

struct Hdf5Reader::Impl {
  fs::path path;
  double file_size = 0;
  Handle file;

  Impl(const fs::path& name, Look look) : path(name) {
    hdf5::silence();
    std::error_code error;
    const auto status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found) fail("no such file");
    if (!fs::exists(status)) fail("cannot be opened: " + error.message());
    if (fs::is_directory(status)) fail("is a directory, not an HDF5 file");
    if (!fs::is_regular_file(status)) fail("is not a regular file");
    file_size = static_cast<double>(fs::file_size(path, error));
    errno = 0;
    if (!std::ifstream(path).is_open())
      fail(std::string("cannot be opened: ") + std::strerror(errno));
    if (file_size == 0) fail("is empty");
    if (H5Fis_hdf5(path.c_str()) <= 0) fail("is not an HDF5 file" + cure(path));
    const bool whole = look == Look::all;
    if (!hdf5::is_sound(path, whole, [&] { visit(path, look); }))
      fail("cannot be read: the HDF5 file is damaged");
    file = open_read_only(path);
    if (!file.ok()) fail("cannot be read: the HDF5 file is truncated or damaged");
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(path.string() + ": " + what);
  }
  [[noreturn]] void fail(const std::string& object, const std::string& what) const {
    fail(object + ": " + what);
  }

  // H5Lexists wants every group on the way to be there.
  bool exists(const std::string& object) const {
    if (object == "/") return true;
    for (auto slash = object.find('/', 1);; slash = object.find('/', slash + 1)) {
      const std::string part = object.substr(0, slash);
      refuse_external(part);
      if (H5Lexists(file, part.c_str(), H5P_DEFAULT) <= 0 ||
          H5Oexists_by_name(file, part.c_str(), H5P_DEFAULT) <= 0)
        return false;
      if (slash == std::string::npos) return true;
    }
  }

  // A foreign file must not copy other files that the user may read into results.
  void refuse_external(const std::string& object) const {
    H5L_info_t info;
    if (H5Lget_info(file, object.c_str(), &info, H5P_DEFAULT) >= 0 &&
        info.type == H5L_TYPE_EXTERNAL)
      fail(object, "is a link to another file, which is not followed");
  }

  void refuse_external_data(hid_t dataset, const std::string& name) const {
    const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
    if (H5Pget_external_count(properties) > 0 || H5Pget_layout(properties) == H5D_VIRTUAL)
      fail(name, "has its values in another file, which is not read");
  }

  Handle open_object(const std::string& object) const {
    if (!exists(object)) fail(object, "missing");
    Handle opened(H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose);
    if (!opened.ok()) fail(object, "cannot be read: the file is damaged");
    return opened;
  }

  Handle open_dataset(const std::string& name) const {
    if (!exists(name)) fail(name, "missing");
    Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) fail(name, "is not a dataset, or the file is damaged");
    refuse_external_data(dataset, name);
    return dataset;
  }

  std::vector<Index> shape(hid_t dataset, const std::string& name) const {
    const Handle space(H5Dget_space(dataset), H5Sclose);
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank < 0 || H5Sget_simple_extent_type(space) == H5S_NULL) fail(name, "holds no array");
    std::vector<hsize_t> extent(rank);
    H5Sget_simple_extent_dims(space, extent.data(), nullptr);
    return {extent.begin(), extent.end()};
  }

  // Shape of a dataset that is about to be read: of that class and rank, and with as much in the
  // file as it claims.
  std::vector<Index> expect(hid_t dataset, const std::string& name, H5T_class_t type_class,
                            std::size_t rank) const {
    const Handle type(H5Dget_type(dataset), H5Tclose);
    if (H5Tget_class(type) != type_class) {
      fail(name, std::string("wrong type, expected ") +
                     (type_class == H5T_FLOAT ? "floating-point numbers" : "whole numbers"));
    }
    const auto extent = shape(dataset, name);
    if (rank > 0 && extent.size() != rank) {
      fail(name, "wrong shape (" + shape_text(extent) + "), expected " + std::to_string(rank) +
                     (rank == 1 ? " dimension" : " dimensions"));
    }
    double bytes = static_cast<double>(H5Tget_size(type));
    for (const Index length : extent) bytes *= static_cast<double>(length);
    const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
    const H5D_layout_t layout = H5Pget_layout(properties);
    // Deflate, the strongest filter that HDF5 brings along, shrinks at most 1032 times.
    const double most = (layout == H5D_CHUNKED ? 1032.0 : 1.0) *
                        std::min(file_size, static_cast<double>(H5Dget_storage_size(dataset)));
    if (bytes > most)
      fail(name,
           "shape (" + shape_text(extent) + ") is more than the file holds: truncated or damaged");
    return extent;
  }

  static std::string shape_text(const std::vector<Index>& extent) {
    std::vector<std::string> words;
    for (const Index length : extent) words.push_back(std::to_string(length));
    return join(words);
  }

  // Of 8 bytes a number
  void read_whole(hid_t dataset, const std::string& name, hid_t memory_type, void* data,
                  Index size) const {
    if (size == 0) return;
    if (H5Dread(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) {
      fail(name, "cannot be read: the file is truncated or damaged");
    }
    if (!has_checksum(dataset)) return;
    Checksum checksum;
    checksum.add(data, 8 * static_cast<std::size_t>(size));
    require_checksum(dataset, name, checksum);
  }

  // Values: a vector or a row-major table, of double or Index
  template <typename Values>
  Values read(const std::string& name) const {
    constexpr bool real = std::is_same_v<typename Values::Scalar, double>;
    constexpr bool is_table = Values::ColsAtCompileTime != 1;
    const Handle dataset = open_dataset(name);
    const auto extent = expect(dataset, name, real ? H5T_FLOAT : H5T_INTEGER, is_table ? 2 : 1);
    Values values(extent[0], is_table ? extent.back() : 1);
    read_whole(dataset, name, real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, values.data(),
               values.size());
    return values;
  }

  static bool has_checksum(hid_t dataset) {
    return H5Aexists(dataset, hdf5::checksum_attribute) > 0;
  }

  void require_checksum(hid_t dataset, const std::string& name, const Checksum& checksum) const {
    const auto value = hdf5::checksum_of(dataset);
    if (!value) fail(name, "attribute 'checksum' is not one whole number");
    if (*value == checksum.value()) return;
    fail(name,
         "its numbers are not those that were written (attribute 'checksum'): the file was damaged "
         "or edited; make it anew (for a "
         "superelement: cbr-reduce --force), or, where the change is meant, delete the attribute");
  }

  // In pieces: `use` has the number of the first row and the rows.
  template <typename Use>
  void read_rows(hid_t dataset, const std::string& name, Index n_rows, Index n_columns,
                 const Use& use) const {
    if (n_rows == 0 || n_columns == 0) return;
    const bool checked = has_checksum(dataset);
    Checksum checksum;
    RowMatrix rows;
    for (Index first = 0, step = hdf5::panel_rows(n_columns); first < n_rows; first += step) {
      rows.resize(std::min<Index>(step, n_rows - first), n_columns);
      const auto [memory, of_file] = hdf5::panel(dataset, first, rows.rows(), n_columns);
      if (H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, of_file, H5P_DEFAULT, rows.data()) < 0)
        fail(name, "cannot be read: the file is truncated or damaged");
      if (checked) checksum.add(rows.data(), 8 * static_cast<std::size_t>(rows.size()));
      use(first, rows);
    }
    if (checked) require_checksum(dataset, name, checksum);
  }

  // Of all below `object`; what has several names is read once. known: checksums by address.
  void compare(const std::string& object, std::map<haddr_t, std::optional<Index>>& known,
               ComparedChecksums& found) const {
    const Handle opened = open_object(object);
    texts(opened, object);
    H5O_info_t info;
    if (H5Oget_info2(opened, &info, H5O_INFO_BASIC) < 0)
      fail(object, "cannot be read: the file is damaged");
    const auto [known_as, is_new] = known.try_emplace(info.addr);
    if (info.type == H5O_TYPE_GROUP && is_new) {
      for (const std::string& name : children(object))
        compare((object == "/" ? "" : object) + "/" + name, known, found);
    }
    if (info.type != H5O_TYPE_DATASET) return;
    if (is_new && has_checksum(opened)) {
      compare(object);
      known_as->second = hdf5::checksum_of(opened);
    }
    if (known_as->second) found.digest ^= hdf5::digest_term(object, *known_as->second);
    if (is_new) ++(known_as->second ? found.datasets : found.without);
  }

  void compare(const std::string& name) const {
    const Handle dataset = open_dataset(name);
    const bool real = H5Tget_class(Handle(H5Dget_type(dataset), H5Tclose)) == H5T_FLOAT;
    const auto extent = expect(dataset, name, real ? H5T_FLOAT : H5T_INTEGER, 0);
    if (real && extent.size() == 2)
      return read_rows(dataset, name, extent[0], extent[1], [](Index, const RowMatrix&) {});
    const Index size = std::accumulate(extent.begin(), extent.end(), Index{1}, std::multiplies<>());
    read_whole(dataset, name, real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, Vector(size).data(),
               size);
  }

  std::vector<std::string> children(const std::string& group) const {
    const Handle owner = open_object(group);
    if (H5Iget_type(owner) != H5I_GROUP) fail(group, "is not a group");
    std::vector<std::string> names;
    if (H5Literate(owner, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_name<H5L_info_t>, &names) <
        0)
      fail(group, "cannot be read: damaged");
    return names;
  }

  std::map<std::string, std::string> texts(hid_t owner, const std::string& object) const {
    std::vector<std::string> names;
    if (H5Aiterate2(owner, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_name<H5A_info_t>, &names) <
        0)
      fail(object, "cannot be read: damaged");
    std::map<std::string, std::string> found;
    std::vector<Index> missing = hdf5::text_checksums(owner);
    for (const std::string& name : names) {
      const Handle attribute(H5Aopen(owner, name.c_str(), H5P_DEFAULT), H5Aclose);
      const Handle space(H5Aget_space(attribute), H5Sclose);
      const Handle type(H5Aget_type(attribute), H5Tclose);
      if (H5Sget_simple_extent_npoints(space) != 1 || H5Tget_class(type) != H5T_STRING) continue;
      found[name] = read_text(attribute, object, name);
      std::erase(missing, hdf5::text_checksum(name, found[name]));
    }
    if (!missing.empty())
      fail(object,
           "its texts are not those that were written (attribute 'checksums_of_texts'): the file "
           "was damaged or edited; make it anew, or, where the change is meant, delete the "
           "attribute");
    return found;
  }

  std::string read_text(hid_t opened, const std::string& object, const std::string& name) const {
    const Handle type(H5Aget_type(opened), H5Tclose);
    if (H5Tget_class(type) != H5T_STRING) fail(object, "attribute '" + name + "' is not a string");
    if (H5Tis_variable_str(type) > 0) {
      char* text = nullptr;
      if (H5Aread(opened, type, &text) < 0)
        fail(object, "attribute '" + name + "' cannot be read: damaged");
      const std::string value = text != nullptr ? text : "";
      H5free_memory(text);
      return value;
    }
    constexpr std::size_t longest = std::size_t{1} << 20;
    if (H5Tget_size(type) > longest)
      fail(object, "attribute '" + name + "' is longer than any text should be: damaged");
    std::string value(H5Tget_size(type), '\0');
    if (H5Aread(opened, type, value.data()) < 0)
      fail(object, "attribute '" + name + "' cannot be read: damaged");
    return value.substr(0, value.find('\0'));
  }

  Handle open_attribute(hid_t owner, const std::string& object, const std::string& name) const {
    if (H5Aexists(owner, name.c_str()) <= 0) fail(object, "attribute '" + name + "' missing");
    Handle attribute(H5Aopen(owner, name.c_str(), H5P_DEFAULT), H5Aclose);
    if (!attribute.ok())
      fail(object, "attribute '" + name + "' cannot be read: the file is damaged");
    const Handle space(H5Aget_space(attribute), H5Sclose);
    if (H5Sget_simple_extent_npoints(space) != 1)
      fail(object, "attribute '" + name + "' is not one value");
    return attribute;
  }
};

Hdf5Reader::Hdf5Reader(const fs::path& file, Look look)
    : impl_(std::make_unique<Impl>(file, look)) {}
Hdf5Reader::~Hdf5Reader() = default;

const fs::path& Hdf5Reader::file() const { return impl_->path; }
bool Hdf5Reader::has(const std::string& object) const { return impl_->exists(object); }

std::vector<std::string> Hdf5Reader::children(const std::string& group) const {
  return impl_->children(group);
}

ComparedChecksums Hdf5Reader::compare_checksums(const std::string& group) const {
  std::map<haddr_t, std::optional<Index>> known;
  ComparedChecksums found;
  impl_->compare(group, known, found);
  return found;
}

std::vector<Index> Hdf5Reader::shape(const std::string& dataset) const {
  return impl_->shape(impl_->open_dataset(dataset), dataset);
}

double Hdf5Reader::read_scalar(const std::string& dataset) const {
  const Handle opened = impl_->open_dataset(dataset);
  const auto extent = impl_->expect(opened, dataset, H5T_FLOAT, 0);
  if (!extent.empty() && extent != std::vector<Index>{1}) {
    impl_->fail(dataset, "wrong shape (" + Impl::shape_text(extent) + "), expected one number");
  }
  double value = 0;
  impl_->read_whole(opened, dataset, H5T_NATIVE_DOUBLE, &value, 1);
  return value;
}

Vector Hdf5Reader::read_vector(const std::string& dataset) const {
  return impl_->read<Vector>(dataset);
}

Matrix Hdf5Reader::read_matrix(const std::string& dataset) const {
  const Handle opened = impl_->open_dataset(dataset);
  const auto extent = impl_->expect(opened, dataset, H5T_FLOAT, 2);
  Matrix values(extent[0], extent[1]);
  impl_->read_rows(
      opened, dataset, values.rows(), values.cols(),
      [&](Index first, const RowMatrix& rows) { values.middleRows(first, rows.rows()) = rows; });
  return values;
}

RowMatrix Hdf5Reader::read_row_matrix(const std::string& dataset) const {
  return impl_->read<RowMatrix>(dataset);
}

Points Hdf5Reader::read_points(const std::string& dataset) const {
  const auto extent = shape(dataset);
  if (extent.size() == 2 && extent[1] != 3)
    impl_->fail(dataset, "wrong shape (" + Impl::shape_text(extent) + "), expected 3 columns");
  return impl_->read<Points>(dataset);
}

std::vector<Index> Hdf5Reader::read_indices(const std::string& dataset) const {
  const auto values = impl_->read<Eigen::VectorX<Index>>(dataset);
  return {values.begin(), values.end()};
}

IndexTable Hdf5Reader::read_index_table(const std::string& dataset) const {
  return impl_->read<IndexTable>(dataset);
}

std::vector<std::string> Hdf5Reader::read_texts(const std::string& dataset) const {
  const Handle opened = impl_->open_dataset(dataset);
  const Handle type(H5Dget_type(opened), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type);
  const std::size_t length = H5Tget_size(type);
  const bool is_text = kind == H5T_STRING && H5Tis_variable_str(type) == 0;
  const Handle byte(kind == H5T_ARRAY ? H5Tget_super(type) : H5Tcopy(type), H5Tclose);
  if (!is_text &&
      (kind != H5T_ARRAY || H5Tget_class(byte) != H5T_INTEGER || H5Tget_size(byte) != 1))
    impl_->fail(dataset, "wrong type, expected texts of one length");
  const auto extent = impl_->expect(opened, dataset, kind, 1);
  std::string all(static_cast<std::size_t>(extent[0]) * length, '\0');
  if (!all.empty() && H5Dread(opened, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) < 0)
    impl_->fail(dataset, "cannot be read: the file is truncated or damaged");
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < all.size(); at += length) texts.push_back(all.substr(at, length));
  return texts;
}

bool Hdf5Reader::has_attribute(const std::string& object, const std::string& attribute) const {
  return H5Aexists(impl_->open_object(object), attribute.c_str()) > 0;
}

std::map<std::string, std::string> Hdf5Reader::texts(const std::string& object) const {
  return has(object) ? impl_->texts(impl_->open_object(object), object)
                     : std::map<std::string, std::string>();
}

std::string Hdf5Reader::read_string(const std::string& object, const std::string& attribute) const {
  const Handle owner = impl_->open_object(object);
  impl_->texts(owner, object);
  return impl_->read_text(impl_->open_attribute(owner, object, attribute), object, attribute);
}

Index Hdf5Reader::read_index(const std::string& object, const std::string& attribute) const {
  const Handle opened = impl_->open_attribute(impl_->open_object(object), object, attribute);
  const Handle type(H5Aget_type(opened), H5Tclose);
  if (H5Tget_class(type) != H5T_INTEGER)
    impl_->fail(object, "attribute '" + attribute + "' is not a whole number");
  Index value = 0;
  if (H5Aread(opened, H5T_NATIVE_INT64, &value) < 0)
    impl_->fail(object, "attribute '" + attribute + "' cannot be read: damaged");
  return value;
}

}  // namespace cbr
