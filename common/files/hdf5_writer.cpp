// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>

#include "common/base/checksum.hpp"
#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/hdf5_handle.hpp"
#include "common/files/output_file.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;
using hdf5::Handle;

// The library would close all files once more at the end of the program, with those that could not
// be written; ours are closed long before. Must precede any use of it: netCDF uses it as well.
[[maybe_unused]] const bool no_exit_handler = H5dont_atexit() >= 0;
// A file names filters by number, for which the library would load code from the folders of
// HDF5_PLUGIN_PATH; ours needs none.
[[maybe_unused]] const bool no_plugins = H5PLset_loading_state(0) >= 0;

// Checksums are of bytes in memory, which are those in the file
static_assert(std::endian::native == std::endian::little);

Handle string_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

// Creation properties without time stamps (groups, datasets, the root group).
Handle timeless(hid_t kind) {
  Handle properties(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  return properties;
}

}  // namespace

struct Hdf5Writer::Impl {
  TemporaryFile temporary;
  Handle file;
  bool checksums = false, compresses = false;
  Index digest = 0;

  explicit Impl(const fs::path& target) : temporary(target) {
    hdf5::silence();
    file = Handle(
        H5Fcreate(temporary.path().c_str(), H5F_ACC_TRUNC, timeless(H5P_FILE_CREATE), access()),
        H5Fclose);
    if (!file.ok()) fail("", "cannot be created");
  }

  Impl(const fs::path& target, const fs::path& from) : temporary(target) {
    hdf5::silence();
    temporary.fill_with(from);
    file = Handle(H5Fopen(temporary.path().c_str(), H5F_ACC_RDWR, access()), H5Fclose);
    if (!file.ok()) throw InputError(from.string() + ": is no HDF5 file, or is damaged");
  }

  static Handle access() {
    Handle properties(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_libver_bounds(properties, H5F_LIBVER_V18, H5F_LIBVER_V18);
    // Else small datasets are buffered until they are closed, and a failed write goes unnoticed:
    // the file would be whole but for zeros.
    H5Pset_sieve_buf_size(properties, 0);
#if H5_VERSION_GE(1, 10, 7)
    // the file is ours alone; locks only fail on network disks
    H5Pset_file_locking(properties, false, true);
#endif
    return properties;
  }

  ~Impl() {
    if (file.ok()) abandon();
  }

  [[noreturn]] void fail(const std::string& object, const std::string& what) const {
    const int error = errno;
    const std::string reason = error != 0 ? std::string(": ") + std::strerror(error) : "";
    throw RunError(temporary.target().string() + ": " + (object.empty() ? "" : object + ": ") +
                   what + reason);
  }

  void require(bool ok, const std::string& object) const {
    if (!ok) fail(object, "cannot be written");
  }

  // Never closes a failed file. A close that fails (disk full) leaves the library with a
  // half-closed file. The next file or the end of the program is then a segmentation fault
  // (1.10.8). The descriptor stays open, too: the library identifies files by their inode, which
  // must not go to another file. The file's space is freed.
  void abandon() {
    void* driver = nullptr;
    if (H5Fget_vfd_handle(file, H5P_DEFAULT, &driver) >= 0 && driver != nullptr) {
      [[maybe_unused]] const int result = ::ftruncate(*static_cast<int*>(driver), 0);
    }
    file.release();
  }

  // Groups above `object`, each without time stamps.
  void make_groups(const std::string& object) const {
    for (auto slash = object.find('/', 1); slash != std::string::npos;
         slash = object.find('/', slash + 1)) {
      make_group(object.substr(0, slash));
    }
  }

  void make_group(const std::string& group) const {
    if (H5Lexists(file, group.c_str(), H5P_DEFAULT) > 0) return;
    const Handle made(
        H5Gcreate2(file, group.c_str(), H5P_DEFAULT, timeless(H5P_GROUP_CREATE), H5P_DEFAULT),
        H5Gclose);
    require(made.ok(), group);
  }

  Handle make_dataset(const std::string& name, hid_t type,
                      const std::vector<hsize_t>& shape) const {
    errno = 0;
    make_groups(name);
    const Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                       H5Sclose);
    const Handle properties = timeless(H5P_DATASET_CREATE);
    if (compresses && shape.size() == 1 && shape[0] > 0) {
      constexpr hsize_t most = 1 << 20;  // a chunk of 8 MB
      const hsize_t chunk = std::min(shape[0], most);
      H5Pset_chunk(properties, 1, &chunk);
      H5Pset_shuffle(properties);
      H5Pset_deflate(properties, 6);
    }
    Handle dataset(
        H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT),
        H5Dclose);
    require(dataset.ok(), name);
    return dataset;
  }

  void write_checksum(hid_t dataset, const std::string& name, const Checksum& checksum) {
    const Index value = checksum.value();
    write_attribute(dataset, name, hdf5::checksum_attribute, H5T_STD_I64LE, H5T_NATIVE_INT64,
                    &value);
    digest ^= hdf5::digest_term(name, value);
  }

  // `data` is row-major, as in the file. Number: double or Index
  template <typename Number>
  void write_whole(const std::string& name, const std::vector<Index>& extent, const Number* data) {
    const bool real = std::is_same_v<Number, double>;
    const std::vector<hsize_t> shape(extent.begin(), extent.end());
    const Handle dataset = make_dataset(name, real ? H5T_IEEE_F64LE : H5T_STD_I64LE, shape);
    const hid_t memory_type = real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
    std::size_t size = 1;
    for (const hsize_t length : shape) size *= length;
    require(size == 0 || H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0,
            name);
    if (!checksums) return;
    Checksum checksum;
    checksum.add(data, 8 * size);
    write_checksum(dataset, name, checksum);
  }

  Handle open_or_make(const std::string& object) const {
    errno = 0;
    make_groups(object);
    if (object != "/") make_group(object);
    return {H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose};
  }

  void write_text(const std::string& object, const std::string& name, const std::string& value) {
    const Handle owner = open_or_make(object);
    const char* text = value.c_str();
    write_attribute(owner, object, name, string_type(), string_type(), &text);
    if (!checksums) return;
    std::vector<Index> of_all = hdf5::text_checksums(owner);
    if (!of_all.empty()) require(H5Adelete(owner, hdf5::checksums_of_texts) >= 0, object);
    of_all.push_back(hdf5::text_checksum(name, value));
    const hsize_t n = of_all.size();
    write_attribute(owner, object, hdf5::checksums_of_texts, H5T_STD_I64LE, H5T_NATIVE_INT64,
                    of_all.data(), Handle(H5Screate_simple(1, &n, nullptr), H5Sclose));
  }

  void write_attribute(hid_t owner, const std::string& object, const std::string& name, hid_t type,
                       hid_t memory_type, const void* value,
                       const Handle& space = {H5Screate(H5S_SCALAR), H5Sclose}) const {
    const Handle attribute(H5Acreate2(owner, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose);
    require(attribute.ok() && H5Awrite(attribute, memory_type, value) >= 0,
            object + ", attribute " + name);
  }
};

Hdf5Writer::Hdf5Writer(const fs::path& file) : impl_(std::make_unique<Impl>(file)) {}
Hdf5Writer::Hdf5Writer(const fs::path& file, const fs::path& from)
    : impl_(std::make_unique<Impl>(file, from)) {}
Hdf5Writer::~Hdf5Writer() = default;

void Hdf5Writer::write(const std::string& dataset, double value) {
  impl_->write_whole(dataset, {1}, &value);
}

void Hdf5Writer::write(const std::string& dataset, const Vector& values) {
  impl_->write_whole(dataset, {values.size()}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const std::vector<double>& values) {
  impl_->write_whole(dataset, {static_cast<Index>(values.size())}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const std::vector<Index>& values) {
  impl_->write_whole(dataset, {static_cast<Index>(values.size())}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const std::vector<int>& values) {
  write(dataset, std::vector<Index>(values.begin(), values.end()));
}

void Hdf5Writer::write(const std::string& dataset, const IndexTable& values) {
  impl_->write_whole(dataset, {values.rows(), values.cols()}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const Points& values) {
  impl_->write_whole(dataset, {values.rows(), 3}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const RowMatrix& values) {
  impl_->write_whole(dataset, {values.rows(), values.cols()}, values.data());
}

void Hdf5Writer::write(const std::string& dataset, const Matrix& values) {
  const Handle made = impl_->make_dataset(
      dataset, H5T_IEEE_F64LE,
      {static_cast<hsize_t>(values.rows()), static_cast<hsize_t>(values.cols())});
  Checksum checksum;
  RowMatrix rows;
  for (Index first = 0, step = hdf5::panel_rows(values.cols());
       values.size() > 0 && first < values.rows(); first += step) {
    rows = values.middleRows(first, std::min<Index>(step, values.rows() - first));
    const auto [memory, file] = hdf5::panel(made, first, rows.rows(), rows.cols());
    impl_->require(H5Dwrite(made, H5T_NATIVE_DOUBLE, memory, file, H5P_DEFAULT, rows.data()) >= 0,
                   dataset);
    if (impl_->checksums)
      checksum.add(rows.data(), sizeof(double) * static_cast<std::size_t>(rows.size()));
  }
  if (impl_->checksums) impl_->write_checksum(made, dataset, checksum);
}

void Hdf5Writer::start(const std::string& format, const std::string& version,
                       const std::string& program) {
  add_checksums();
  attribute("/", "format", format);
  attribute("/", "format_version", version);
  attribute("/", "generator", program + " " + cbr::version());
}

void Hdf5Writer::compress(bool all) { impl_->compresses = all; }

void Hdf5Writer::add_checksums(Index digest) {
  impl_->checksums = true;
  impl_->digest = digest;
}

Index Hdf5Writer::digest() const { return impl_->digest; }

void Hdf5Writer::link(const std::string& dataset, const std::string& name) {
  errno = 0;
  impl_->make_groups(name);
  impl_->require(H5Lcreate_hard(impl_->file, dataset.c_str(), impl_->file, name.c_str(),
                                H5P_DEFAULT, H5P_DEFAULT) >= 0,
                 name);
  if (!impl_->checksums) return;
  const Handle linked(H5Dopen2(impl_->file, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (const auto value = hdf5::checksum_of(linked))
    impl_->digest ^= hdf5::digest_term(name, *value);
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name,
                           const std::string& value) {
  impl_->write_text(object, name, value);
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, Index value) {
  impl_->write_attribute(impl_->open_or_make(object), object, name, H5T_STD_I64LE, H5T_NATIVE_INT64,
                         &value);
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, double value) {
  impl_->write_attribute(impl_->open_or_make(object), object, name, H5T_IEEE_F64LE,
                         H5T_NATIVE_DOUBLE, &value);
}

bool Hdf5Writer::remove(const std::string& object) {
  if (H5Lexists(impl_->file, object.c_str(), H5P_DEFAULT) <= 0) return false;
  impl_->require(H5Ldelete(impl_->file, object.c_str(), H5P_DEFAULT) >= 0, object);
  return true;
}

void Hdf5Writer::save_copy(const fs::path& target) {
  errno = 0;
  impl_->require(H5Fflush(impl_->file, H5F_SCOPE_GLOBAL) >= 0, "");
  write_copy(impl_->temporary.path(), target);
}

void Hdf5Writer::close() {
  errno = 0;
  // Flushed before it is closed: a flush that fails leaves the file in our hands, a close that
  // fails does not.
  impl_->require(H5Fflush(impl_->file, H5F_SCOPE_GLOBAL) >= 0, "");
  impl_->require(H5Fclose(impl_->file.release()) >= 0, "");
}

void Hdf5Writer::commit() {
  close();
  impl_->temporary.commit();
}

void Hdf5Writer::use_and_remove(const std::function<void(const fs::path& file)>& use) {
  close();
  use(impl_->temporary.path());
}

}  // namespace cbr
