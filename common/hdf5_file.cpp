// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/hdf5_file.hpp"

#include <fcntl.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "common/error.hpp"
#include "common/output_file.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

// An HDF5 identifier that closes itself.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close close) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_), std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }
  bool ok() const { return id_ >= 0; }
  hid_t release() { return std::exchange(id_, -1); }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

// The library prints its error stack unless told not to; the setting is per thread.
void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

// Rows copied at once between a column-major matrix and the file's rows: 16 MB, whatever the matrix's size.
Index panel_rows(Index columns) { return std::max<Index>(1, (Index{1} << 21) / std::max<Index>(1, columns)); }

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Memory and file spaces of rows [first, first + rows) of a two-dimensional dataset.
std::pair<Handle, Handle> panel(hid_t dataset, Index first, Index rows, Index columns) {
  const hsize_t start[2] = {static_cast<hsize_t>(first), 0};
  const hsize_t count[2] = {static_cast<hsize_t>(rows), static_cast<hsize_t>(columns)};
  Handle memory(H5Screate_simple(2, count, nullptr), H5Sclose), file(H5Dget_space(dataset), H5Sclose);
  H5Sselect_hyperslab(file, H5S_SELECT_SET, start, nullptr, count, nullptr);
  return {std::move(memory), std::move(file)};
}

Handle string_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

// Creation properties without time stamps, for what `make` makes (groups, datasets, the root group).
Handle timeless(hid_t kind) {
  Handle properties(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  return properties;
}

}  // namespace

// --- writing ---------------------------------------------------------------------------------------------------------

struct Hdf5Writer::Impl {
  TemporaryFile temporary;
  Handle file;

  explicit Impl(const fs::path& target) : temporary(target) {
    silence();
    Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18);
    file = Handle(H5Fcreate(temporary.path().c_str(), H5F_ACC_TRUNC, timeless(H5P_FILE_CREATE), access), H5Fclose);
    if (!file.ok()) fail("", "cannot be created");
  }

  ~Impl() {
    if (file.ok()) abandon();
  }

  [[noreturn]] void fail(const std::string& object, const std::string& what) const {
    const int error = errno;
    const std::string reason = error != 0 ? std::string(": ") + std::strerror(error) : "";
    throw RunError(temporary.target().string() + ": " + (object.empty() ? "" : object + ": ") + what + reason);
  }

  void require(bool ok, const std::string& object) const {
    if (!ok) fail(object, "cannot be written");
  }

  // Closing writes what the library still holds, and a file that cannot be closed (disk full) stays open inside the library,
  // which then hangs on to it until the program ends. The contents no longer matter here: let them go to /dev/null.
  void abandon() {
    void* driver = nullptr;
    const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    if (nowhere >= 0 && H5Fget_vfd_handle(file, H5P_DEFAULT, &driver) >= 0 && driver != nullptr) {
      ::dup2(nowhere, *static_cast<int*>(driver));
    }
    if (nowhere >= 0) ::close(nowhere);
    file = Handle();
  }

  // Groups above `object`, each without time stamps.
  void make_groups(const std::string& object) const {
    for (auto slash = object.find('/', 1); slash != std::string::npos; slash = object.find('/', slash + 1)) {
      make_group(object.substr(0, slash));
    }
  }

  void make_group(const std::string& group) const {
    if (H5Lexists(file, group.c_str(), H5P_DEFAULT) > 0) return;
    const Handle made(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, timeless(H5P_GROUP_CREATE), H5P_DEFAULT), H5Gclose);
    require(made.ok(), group);
  }

  Handle make_dataset(const std::string& name, hid_t type, const std::vector<hsize_t>& shape) const {
    errno = 0;
    make_groups(name);
    const Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
    Handle dataset(H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, timeless(H5P_DATASET_CREATE), H5P_DEFAULT), H5Dclose);
    require(dataset.ok(), name);
    return dataset;
  }

  // `data` is row-major, as in the file.
  void write_whole(const std::string& name, hid_t file_type, hid_t memory_type, const std::vector<hsize_t>& shape,
                   const void* data) const {
    const Handle dataset = make_dataset(name, file_type, shape);
    const bool empty = std::find(shape.begin(), shape.end(), 0) != shape.end();
    require(empty || H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0, name);
  }

  void write_attribute(const std::string& object, const std::string& name, hid_t type, hid_t memory_type, const void* value) const {
    errno = 0;
    make_groups(object);
    if (object != "/") make_group(object);
    const Handle owner(H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose), space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle attribute(H5Acreate2(owner, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    require(attribute.ok() && H5Awrite(attribute, memory_type, value) >= 0, object + ", attribute " + name);
  }
};

Hdf5Writer::Hdf5Writer(const fs::path& file) : impl_(std::make_unique<Impl>(file)) {}
Hdf5Writer::~Hdf5Writer() = default;

void Hdf5Writer::write(const std::string& dataset, double value) {
  impl_->write_whole(dataset, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {1}, &value);
}

void Hdf5Writer::write(const std::string& dataset, const Vector& values) {
  impl_->write_whole(dataset, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {static_cast<hsize_t>(values.size())}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const std::vector<double>& values) {
  impl_->write_whole(dataset, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {values.size()}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const std::vector<Index>& values) {
  impl_->write_whole(dataset, H5T_STD_I64LE, H5T_NATIVE_INT64, {values.size()}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const std::vector<int>& values) {
  impl_->write_whole(dataset, H5T_STD_I64LE, H5T_NATIVE_INT, {values.size()}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const IndexTable& values) {
  impl_->write_whole(dataset, H5T_STD_I64LE, H5T_NATIVE_INT64,
                     {static_cast<hsize_t>(values.rows()), static_cast<hsize_t>(values.cols())}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const Points& values) {
  impl_->write_whole(dataset, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {static_cast<hsize_t>(values.rows()), 3}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const Matrix& values) {
  const Handle made =
      impl_->make_dataset(dataset, H5T_IEEE_F64LE, {static_cast<hsize_t>(values.rows()), static_cast<hsize_t>(values.cols())});
  if (values.size() == 0) return;
  RowMajor rows;
  for (Index first = 0, step = panel_rows(values.cols()); first < values.rows(); first += step) {
    rows = values.middleRows(first, std::min<Index>(step, values.rows() - first));
    const auto [memory, file] = panel(made, first, rows.rows(), rows.cols());
    impl_->require(H5Dwrite(made, H5T_NATIVE_DOUBLE, memory, file, H5P_DEFAULT, rows.data()) >= 0, dataset);
  }
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, const std::string& value) {
  const char* text = value.c_str();
  impl_->write_attribute(object, name, string_type(), string_type(), &text);
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, Index value) {
  impl_->write_attribute(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, double value) {
  impl_->write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5Writer::commit() {
  errno = 0;
  // Flushed before it is closed: a flush that fails leaves the file in our hands, a close that fails does not.
  impl_->require(H5Fflush(impl_->file, H5F_SCOPE_GLOBAL) >= 0, "");
  if (H5Fclose(impl_->file) < 0) impl_->fail("", "cannot be written");
  impl_->file.release();
  impl_->temporary.commit();
}

// --- reading ---------------------------------------------------------------------------------------------------------

struct Hdf5Reader::Impl {
  fs::path path;
  double file_size = 0;
  Handle file;

  explicit Impl(const fs::path& name) : path(name) {
    silence();
    std::error_code error;
    const auto status = fs::status(path, error);
    if (!fs::exists(status)) fail("no such file");
    if (fs::is_directory(status)) fail("is a directory, not an HDF5 file");
    if (!fs::is_regular_file(status)) fail("is not a regular file");
    file_size = static_cast<double>(fs::file_size(path, error));
    errno = 0;
    if (!std::ifstream(path).is_open()) fail(std::string("cannot be opened: ") + std::strerror(errno));
    if (file_size == 0) fail("is empty");
    if (H5Fis_hdf5(path.c_str()) <= 0) fail("is not an HDF5 file");
    Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
#if H5_VERSION_GE(1, 10, 7)
    H5Pset_file_locking(access, false, true);  // a file is renamed when whole, never changed: locks only fail on network disks
#endif
    file = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
    if (!file.ok()) fail("cannot be read: the HDF5 file is truncated or damaged");
  }

  [[noreturn]] void fail(const std::string& what) const { throw InputError(path.string() + ": " + what); }
  [[noreturn]] void fail(const std::string& object, const std::string& what) const { fail(object + ": " + what); }

  // H5Lexists wants every group on the way to be there.
  bool exists(const std::string& object) const {
    if (object == "/") return true;
    for (auto slash = object.find('/', 1);; slash = object.find('/', slash + 1)) {
      const std::string part = object.substr(0, slash);
      if (H5Lexists(file, part.c_str(), H5P_DEFAULT) <= 0 || H5Oexists_by_name(file, part.c_str(), H5P_DEFAULT) <= 0) return false;
      if (slash == std::string::npos) return true;
    }
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
    return dataset;
  }

  std::vector<Index> shape(hid_t dataset, const std::string& name) const {
    const Handle space(H5Dget_space(dataset), H5Sclose);
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank < 0 || H5Sget_simple_extent_type(space) == H5S_NULL) fail(name, "holds no array");
    std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
    H5Sget_simple_extent_dims(space, extent.data(), nullptr);
    return {extent.begin(), extent.end()};
  }

  // Shape of a dataset that is about to be read: of that class and rank, and with as much in the file as it claims.
  std::vector<Index> expect(hid_t dataset, const std::string& name, H5T_class_t type_class, std::size_t rank) const {
    const Handle type(H5Dget_type(dataset), H5Tclose);
    if (H5Tget_class(type) != type_class) {
      fail(name, std::string("wrong type, expected ") + (type_class == H5T_FLOAT ? "floating-point numbers" : "whole numbers"));
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
    if (layout == H5D_VIRTUAL || H5Pget_external_count(properties) > 0)
      fail(name, "is stored outside of the file, which is not read");
    // Deflate, the strongest filter that HDF5 brings along, shrinks at most 1032 times.
    const double most =
        (layout == H5D_CHUNKED ? 1032.0 : 1.0) * std::min(file_size, static_cast<double>(H5Dget_storage_size(dataset)));
    if (bytes > most) fail(name, "shape (" + shape_text(extent) + ") is more than the file holds: truncated or damaged");
    return extent;
  }

  static std::string shape_text(const std::vector<Index>& extent) {
    std::vector<std::string> words;
    for (const Index length : extent) words.push_back(std::to_string(length));
    return join(words);
  }

  void read_whole(hid_t dataset, const std::string& name, hid_t memory_type, void* data, Index size) const {
    if (size == 0) return;
    if (H5Dread(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) {
      fail(name, "cannot be read: the file is truncated or damaged");
    }
  }

  Handle open_attribute(const std::string& object, const std::string& name) const {
    const Handle owner = open_object(object);
    if (H5Aexists(owner, name.c_str()) <= 0) fail(object, "attribute '" + name + "' missing");
    Handle attribute(H5Aopen(owner, name.c_str(), H5P_DEFAULT), H5Aclose);
    if (!attribute.ok()) fail(object, "attribute '" + name + "' cannot be read: the file is damaged");
    const Handle space(H5Aget_space(attribute), H5Sclose);
    if (H5Sget_simple_extent_npoints(space) != 1) fail(object, "attribute '" + name + "' is not one value");
    return attribute;
  }
};

Hdf5Reader::Hdf5Reader(const fs::path& file) : impl_(std::make_unique<Impl>(file)) {}
Hdf5Reader::~Hdf5Reader() = default;

const fs::path& Hdf5Reader::file() const { return impl_->path; }
bool Hdf5Reader::has(const std::string& object) const { return impl_->exists(object); }

std::vector<std::string> Hdf5Reader::children(const std::string& group) const {
  const Handle owner = impl_->open_object(group);
  if (H5Iget_type(owner) != H5I_GROUP) impl_->fail(group, "is not a group");
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  if (H5Literate(owner, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names) < 0) impl_->fail(group, "cannot be read: damaged");
  return names;
}

std::vector<std::string> Hdf5Reader::attributes(const std::string& object) const {
  const Handle owner = impl_->open_object(object);
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5A_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  if (H5Aiterate2(owner, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names) < 0) impl_->fail(object, "cannot be read: damaged");
  return names;
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
  const Handle opened = impl_->open_dataset(dataset);
  Vector values(impl_->expect(opened, dataset, H5T_FLOAT, 1)[0]);
  impl_->read_whole(opened, dataset, H5T_NATIVE_DOUBLE, values.data(), values.size());
  return values;
}

Matrix Hdf5Reader::read_matrix(const std::string& dataset) const {
  const Handle opened = impl_->open_dataset(dataset);
  const auto extent = impl_->expect(opened, dataset, H5T_FLOAT, 2);
  Matrix values(extent[0], extent[1]);
  if (values.size() == 0) return values;
  RowMajor rows;
  for (Index first = 0, step = panel_rows(values.cols()); first < values.rows(); first += step) {
    rows.resize(std::min<Index>(step, values.rows() - first), values.cols());
    const auto [memory, file] = panel(opened, first, rows.rows(), rows.cols());
    if (H5Dread(opened, H5T_NATIVE_DOUBLE, memory, file, H5P_DEFAULT, rows.data()) < 0) {
      impl_->fail(dataset, "cannot be read: the file is truncated or damaged");
    }
    values.middleRows(first, rows.rows()) = rows;
  }
  return values;
}

Points Hdf5Reader::read_points(const std::string& dataset) const {
  const Handle opened = impl_->open_dataset(dataset);
  const auto extent = impl_->expect(opened, dataset, H5T_FLOAT, 2);
  if (extent[1] != 3) impl_->fail(dataset, "wrong shape (" + Impl::shape_text(extent) + "), expected 3 columns");
  Points values(extent[0], 3);
  impl_->read_whole(opened, dataset, H5T_NATIVE_DOUBLE, values.data(), values.size());
  return values;
}

std::vector<Index> Hdf5Reader::read_indices(const std::string& dataset) const {
  const Handle opened = impl_->open_dataset(dataset);
  std::vector<Index> values(static_cast<std::size_t>(impl_->expect(opened, dataset, H5T_INTEGER, 1)[0]));
  impl_->read_whole(opened, dataset, H5T_NATIVE_INT64, values.data(), static_cast<Index>(values.size()));
  return values;
}

IndexTable Hdf5Reader::read_index_table(const std::string& dataset) const {
  const Handle opened = impl_->open_dataset(dataset);
  const auto extent = impl_->expect(opened, dataset, H5T_INTEGER, 2);
  IndexTable values(extent[0], extent[1]);
  impl_->read_whole(opened, dataset, H5T_NATIVE_INT64, values.data(), values.size());
  return values;
}

bool Hdf5Reader::has_attribute(const std::string& object, const std::string& attribute) const {
  return H5Aexists(impl_->open_object(object), attribute.c_str()) > 0;
}

bool Hdf5Reader::is_string(const std::string& object, const std::string& attribute) const {
  const Handle opened = impl_->open_attribute(object, attribute);
  return H5Tget_class(Handle(H5Aget_type(opened), H5Tclose)) == H5T_STRING;
}

std::string Hdf5Reader::read_string(const std::string& object, const std::string& attribute) const {
  const Handle opened = impl_->open_attribute(object, attribute);
  const Handle type(H5Aget_type(opened), H5Tclose);
  if (H5Tget_class(type) != H5T_STRING) impl_->fail(object, "attribute '" + attribute + "' is not a string");
  if (H5Tis_variable_str(type) > 0) {
    char* text = nullptr;
    if (H5Aread(opened, type, &text) < 0) impl_->fail(object, "attribute '" + attribute + "' cannot be read: damaged");
    const std::string value = text != nullptr ? text : "";
    H5free_memory(text);
    return value;
  }
  std::string value(H5Tget_size(type), '\0');
  if (H5Aread(opened, type, value.data()) < 0) impl_->fail(object, "attribute '" + attribute + "' cannot be read: damaged");
  return value.substr(0, value.find('\0'));
}

Index Hdf5Reader::read_index(const std::string& object, const std::string& attribute) const {
  const Handle opened = impl_->open_attribute(object, attribute);
  const Handle type(H5Aget_type(opened), H5Tclose);
  if (H5Tget_class(type) != H5T_INTEGER) impl_->fail(object, "attribute '" + attribute + "' is not a whole number");
  Index value = 0;
  if (H5Aread(opened, H5T_NATIVE_INT64, &value) < 0) impl_->fail(object, "attribute '" + attribute + "' cannot be read: damaged");
  return value;
}

}  // namespace cbr
