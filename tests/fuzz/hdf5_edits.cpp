// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/hdf5_edits.hpp"

#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/files/hdf5_handle.hpp"

namespace cbr::fuzz {
namespace {

using hdf5::Handle;

constexpr double special_reals[] = {
    0,        -1,        1,      std::numeric_limits<double>::quiet_NaN(),
    HUGE_VAL, -HUGE_VAL, 1e308,  -1e308,
    1e-308,   5e-324,    1e-200, 1e200,
    0.5,      1e16,      -1e-9};
constexpr std::int64_t special_integers[] = {0,
                                             -1,
                                             1,
                                             2,
                                             3,
                                             7,
                                             100,
                                             255,
                                             1 << 20,
                                             std::int64_t{1} << 31,
                                             std::int64_t{1} << 40,
                                             std::numeric_limits<std::int64_t>::max(),
                                             std::numeric_limits<std::int64_t>::min()};
const char* const words[] = {
    "",     "1.0",   "2.0",   "1.",   "cbr-superelement", "cbr-superelement-group",
    "tri3", "quad4", "quad8", "hex8", "craig-bampton",    "characteristic",
    "/",    "..",    "nan",   "x\ny", "\xff\xfe\x80"};

struct Listed {
  std::vector<std::string> datasets, groups;
  std::vector<std::pair<std::string, std::string>> attributes;  // of which object
};

herr_t list_attribute(hid_t object, const char* name, const H5A_info_t*, void* list) {
  // would tell of every edit before anything else is looked at
  if (std::string(name) == "checksum") return 0;
  char path[1024] = "/";
  if (H5Iget_name(object, path, sizeof path) > 0)
    static_cast<Listed*>(list)->attributes.emplace_back(path, name);
  return 0;
}

herr_t list_object(hid_t file, const char* name, const H5O_info_t* info, void* list) {
  const std::string path = std::string(name) == "." ? "/" : "/" + std::string(name);
  auto& names = info->type == H5O_TYPE_DATASET ? static_cast<Listed*>(list)->datasets
                                               : static_cast<Listed*>(list)->groups;
  names.push_back(path);
  const Handle object(H5Oopen(file, path.c_str(), H5P_DEFAULT), H5Oclose);
  if (object.ok()) H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, list_attribute, list);
  return 0;
}

class Editor {
 public:
  Editor(hid_t file, ByteSource& bytes) : file_(file), bytes_(bytes) {
    H5Ovisit(file, H5_INDEX_NAME, H5_ITER_INC, list_object, &listed_);
    for (const std::string& name : listed_.datasets)
      H5Adelete_by_name(file, name.c_str(), "checksum", H5P_DEFAULT);
  }

  void edit() {
    switch (bytes_.below(12)) {
      case 0:
      case 1:
      case 2:
        return set_entry(some(listed_.datasets));
      case 3:
        return remove(some(bytes_.below(3) == 0 ? listed_.groups : listed_.datasets));
      case 4:
      case 5:
        return replace(some(listed_.datasets));
      case 6:
        return link(some(bytes_.below(3) == 0 ? listed_.groups : listed_.datasets));
      case 7:
      case 8:
      case 9:
        return set_attribute();
      case 10:
        return remove_attribute();
      default:
        return add_child(some(listed_.groups));
    }
  }

 private:
  template <class T>
  T some(const std::vector<T>& list) {
    return list.empty() ? T() : list[bytes_.take<std::uint16_t>() % list.size()];
  }

  double real() {
    const std::size_t i = bytes_.below(std::size(special_reals) + 1);
    return i < std::size(special_reals) ? special_reals[i] : bytes_.take<double>();
  }
  std::int64_t integer() {
    const std::size_t i = bytes_.below(std::size(special_integers) + 1);
    return i < std::size(special_integers) ? special_integers[i] : bytes_.take<std::int64_t>();
  }
  std::string word() {
    const std::size_t i = bytes_.below(std::size(words) + 1);
    if (i < std::size(words)) return words[i];
    std::string text(bytes_.below(40), ' ');
    for (char& c : text) c = bytes_.take<char>();
    return text;
  }

  // One entry, and its mirror image half of the times: symmetric matrices get that far
  void set_entry(const std::string& name) {
    const Handle dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) return;
    const Handle space(H5Dget_space(dataset), H5Sclose), type(H5Dget_type(dataset), H5Tclose);
    const hssize_t n = H5Sget_simple_extent_npoints(space);
    if (n < 1 || n > 1 << 20) return;
    hsize_t extent[H5S_MAX_RANK] = {1, 1};
    H5Sget_simple_extent_dims(space, extent, nullptr);
    const auto size = static_cast<std::size_t>(n), at = bytes_.take<std::uint32_t>() % size;
    const std::size_t columns = extent[1] > 0 ? extent[1] : 1,
                      mirror = at % columns * columns + at / columns;
    const bool both =
        bytes_.below(2) == 0 && H5Sget_simple_extent_ndims(space) == 2 && mirror < size;
    if (H5Tget_class(type) == H5T_FLOAT) {
      std::vector<double> values(size);
      H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
      values[at] = real();
      if (both) values[mirror] = values[at];
      H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    } else if (H5Tget_class(type) == H5T_INTEGER) {
      std::vector<std::int64_t> values(size);
      H5Dread(dataset, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
      values[at] = integer();
      H5Dwrite(dataset, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    }
  }

  void remove(const std::string& name) {
    if (name != "/" && !name.empty()) H5Ldelete(file_, name.c_str(), H5P_DEFAULT);
  }

  Handle type() {
    static const hid_t plain[] = {H5T_IEEE_F64LE,  H5T_IEEE_F64BE, H5T_IEEE_F32LE, H5T_STD_I64LE,
                                  H5T_STD_I64BE,   H5T_STD_I8LE,   H5T_STD_U64LE,  H5T_STD_U8BE,
                                  H5T_STD_REF_OBJ, H5T_STD_B8LE,   H5T_UNIX_D32LE, H5T_C_S1,
                                  H5T_IEEE_F64LE,  H5T_STD_I64LE};
    const std::size_t i = bytes_.below(std::size(plain) + 6);
    if (i < std::size(plain)) return {H5Tcopy(plain[i]), H5Tclose};
    const hsize_t three = 3;
    switch (i - std::size(plain)) {
      case 0: {
        Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
        H5Tset_size(text, H5T_VARIABLE);
        return text;
      }
      case 1:
        return {H5Tvlen_create(H5T_NATIVE_DOUBLE), H5Tclose};
      case 2:
        return {H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, &three), H5Tclose};
      case 3: {
        Handle compound(H5Tcreate(H5T_COMPOUND, 16), H5Tclose);
        H5Tinsert(compound, "a", 0, H5T_NATIVE_DOUBLE);
        H5Tinsert(compound, "b", 8, H5T_NATIVE_INT64);
        return compound;
      }
      case 4: {
        Handle enumeration(H5Tenum_create(H5T_NATIVE_INT64), H5Tclose);
        const std::int64_t one = 1;
        H5Tenum_insert(enumeration, "one", &one);
        return enumeration;
      }
      default: {  // floating-point numbers with a layout of their own
        Handle odd(H5Tcopy(H5T_IEEE_F64LE), H5Tclose);
        H5Tset_precision(odd, 48);
        H5Tset_fields(odd, 47, 38, 9, 0, 38);
        H5Tset_size(odd, 6);
        return odd;
      }
    }
  }

  Handle space(std::vector<hsize_t>& extent, bool& resizable) {
    resizable = false;
    const std::size_t kind = bytes_.below(10);
    if (kind == 0) return {H5Screate(H5S_NULL), H5Sclose};
    if (kind == 1) return {H5Screate(H5S_SCALAR), H5Sclose};
    const std::size_t rank = kind < 5 ? 1 : kind < 9 ? 2 : 1 + bytes_.below(6);
    for (std::size_t d = 0; d < rank; ++d) {
      static const hsize_t sizes[] = {0,
                                      1,
                                      2,
                                      3,
                                      4,
                                      8,
                                      12,
                                      24,
                                      27,
                                      36,
                                      1000,
                                      hsize_t{1} << 31,
                                      hsize_t{1} << 40,
                                      hsize_t{1} << 62};
      extent.push_back(sizes[bytes_.below(std::size(sizes))]);
    }
    resizable = bytes_.below(2) == 0;
    const std::vector<hsize_t> most(rank, H5S_UNLIMITED);
    return {
        H5Screate_simple(static_cast<int>(rank), extent.data(), resizable ? most.data() : nullptr),
        H5Sclose};
  }

  // How a dataset is stored: in its header, in one piece, in chunks through filters, in another
  // file, as a view of others.
  Handle storage(const std::vector<hsize_t>& extent, bool resizable, hid_t space) {
    Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const double fill = real();
    if (bytes_.below(3) == 0) H5Pset_fill_value(list, H5T_NATIVE_DOUBLE, &fill);
    const std::size_t kind = bytes_.below(8);
    if (extent.empty()) return list;
    if (kind == 0) H5Pset_layout(list, H5D_COMPACT);
    if (kind == 1) H5Pset_external(list, "/dev/zero", 0, H5F_UNLIMITED);
    if (kind == 2) H5Pset_virtual(list, space, "/dev/null", "/x", space);
    if (kind >= 5 || resizable) {
      std::vector<hsize_t> chunk;
      for (const hsize_t size : extent)
        chunk.push_back(std::max<hsize_t>(1, std::min<hsize_t>(size, 1 + bytes_.below(32))));
      H5Pset_chunk(list, static_cast<int>(chunk.size()), chunk.data());
      if (kind == 5) H5Pset_deflate(list, 9);
      if (kind == 6) {
        H5Pset_shuffle(list);
        H5Pset_fletcher32(list);
      }
      if (kind == 7) H5Pset_scaleoffset(list, H5Z_SO_INT, 0);
    }
    return list;
  }

  void replace(const std::string& name) {
    std::vector<hsize_t> extent;
    bool resizable = false;
    const Handle its_space = space(extent, resizable), its_type = type();
    if (!its_space.ok() || !its_type.ok()) return;
    const Handle list = storage(extent, resizable, its_space);
    remove(name);
    Handle dataset(
        H5Dcreate2(file_, name.c_str(), its_type, its_space, H5P_DEFAULT, list, H5P_DEFAULT),
        H5Dclose);
    double n = 1;
    for (const hsize_t size : extent) n *= static_cast<double>(size);
    const auto kind = H5Tget_class(its_type);
    if (!dataset.ok() || n > 10000 || bytes_.below(4) == 0 ||
        (kind != H5T_FLOAT && kind != H5T_INTEGER))
      return;
    const Handle layout(H5Dget_create_plist(dataset), H5Pclose);
    // nothing is written elsewhere
    if (H5Pget_layout(layout) == H5D_VIRTUAL || H5Pget_external_count(layout) > 0) return;
    const std::vector<double> values(static_cast<std::size_t>(n) + 1, real());
    H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  }

  void link(const std::string& name) {
    const std::string target = bytes_.below(2) == 0 ? some(listed_.groups) : some(listed_.datasets);
    if (name.empty() || name == "/" || target.empty()) return;
    const std::size_t kind = bytes_.below(4);
    if (kind == 0) {  // before the name goes: a group may so hold itself
      const std::string child = name + "/again";
      H5Lcreate_hard(file_, target.c_str(), file_, child.c_str(), H5P_DEFAULT, H5P_DEFAULT);
      return;
    }
    remove(name);
    if (kind == 1)
      H5Lcreate_hard(file_, target.c_str(), file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    if (kind == 2)
      H5Lcreate_soft(bytes_.below(2) == 0 ? name.c_str() : target.c_str(), file_, name.c_str(),
                     H5P_DEFAULT, H5P_DEFAULT);
    if (kind == 3)
      H5Lcreate_external("/dev/zero", "/x", file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
  }

  void write_value(hid_t object, const std::string& name) {
    H5Adelete(object, name.c_str());
    const hsize_t n = 1 + bytes_.below(3);
    const std::size_t kind = bytes_.below(8);
    const Handle scalar(kind == 7   ? H5Screate(H5S_NULL)
                        : kind == 6 ? H5Screate_simple(1, &n, nullptr)
                                    : H5Screate(H5S_SCALAR),
                        H5Sclose);
    const auto create = [&](hid_t its_type) {
      return Handle(H5Acreate2(object, name.c_str(), its_type, scalar, H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
    };
    if (kind < 3) {
      const std::string text = word();
      Handle its_type(H5Tcopy(H5T_C_S1), H5Tclose);
      if (kind == 0) {
        H5Tset_size(its_type, H5T_VARIABLE);
        const char* pointer = text.c_str();
        H5Awrite(create(its_type), its_type, &pointer);
      } else {
        H5Tset_size(its_type, std::max<std::size_t>(1, text.size()));
        H5Tset_strpad(its_type, kind == 1 ? H5T_STR_NULLPAD : H5T_STR_SPACEPAD);
        H5Awrite(create(its_type), its_type, text.c_str());
      }
    } else if (kind < 5) {
      const std::int64_t value[4] = {integer(), 1, 2, 3};
      H5Awrite(create(bytes_.below(2) == 0 ? H5T_STD_I64LE : H5T_STD_U8LE), H5T_NATIVE_INT64,
               value);
    } else {
      create(type());  // left as the library leaves it
    }
  }

  void set_attribute() {
    const auto [path, name] = some(listed_.attributes);
    const Handle object(H5Oopen(file_, path.c_str(), H5P_DEFAULT), H5Oclose);
    if (object.ok()) write_value(object, bytes_.below(8) == 0 ? "novelty" : name);
  }

  void remove_attribute() {
    const auto [path, name] = some(listed_.attributes);
    const Handle object(H5Oopen(file_, path.c_str(), H5P_DEFAULT), H5Oclose);
    if (object.ok()) H5Adelete(object, name.c_str());
  }

  void add_child(const std::string& group) {
    const std::string child =
        (group == "/" ? "" : group) + "/" + (bytes_.below(2) == 0 ? "another" : "000007");
    switch (bytes_.below(3)) {
      case 0:
        Handle(H5Gcreate2(file_, child.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
        return;
      case 1:
        H5Tcommit2(file_, child.c_str(), type(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        return;
      default:
        replace(child);
    }
  }

  hid_t file_;
  ByteSource& bytes_;
  Listed listed_;
};

}  // namespace

void edit_hdf5(const std::filesystem::path& file, ByteSource& bytes) {
  hdf5::silence();
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_LATEST);
  const Handle opened(H5Fopen(file.c_str(), H5F_ACC_RDWR, access), H5Fclose);
  require(opened.ok(), "the file to be edited does not open");
  for (int n = 0; n < 5 && !bytes.empty(); ++n) Editor(opened, bytes).edit();
}

}  // namespace cbr::fuzz
