// SPDX-License-Identifier: GPL-3.0-or-later
// Formats that the program gmsh converts. It runs as a process of its own: the library crashes on
// damaged files (docs/decisions/msh-reader.md), and programs that read .msh alone would load it for
// nothing.
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <string>
#include <system_error>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/text_lines.hpp"
#include "common/files/output_file.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

constexpr int no_program = 127;

// Of this user alone, and removed with all that is in it.
class PrivateFolder {
 public:
  PrivateFolder() {
    std::string name = fs::temp_directory_path() / "cbr-XXXXXX";
    if (mkdtemp(name.data()) == nullptr)
      throw RunError(name + ": cannot be made: " + std::strerror(errno));
    path_ = name;
  }
  ~PrivateFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// gmsh runs scripts of the current folder, of HOME (.gmshrc, .gmsh-options), and those beside the
// file that it reads (mesh.unv.opt): `folder` is all three and has none.
[[noreturn]] void become_gmsh(const fs::path& folder, const fs::path& in, const fs::path& out,
                              unsigned seconds) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit none{0, 0}, time{seconds, seconds + 1};
  setrlimit(RLIMIT_CORE, &none);
  setrlimit(RLIMIT_CPU, &time);
  if (const int nowhere = open("/dev/null", O_RDWR); nowhere >= 0) {
    dup2(nowhere, 0);
    dup2(nowhere, 1);
    dup2(nowhere, 2);
  }
  sigset_t empty;
  sigemptyset(&empty);
  sigprocmask(SIG_SETMASK, &empty, nullptr);
  if (chdir(folder.c_str()) != 0) _exit(no_program);
  for (const char* variable : {"HOME", "GMSH_HOME"}) setenv(variable, folder.c_str(), 1);
  execlp("gmsh", "gmsh", in.c_str(), "-save", "-save_all", "-format", "msh41", "-o", out.c_str(),
         static_cast<char*>(nullptr));
  _exit(no_program);
}

int run_gmsh(const fs::path& folder, const fs::path& in, const fs::path& out, unsigned seconds) {
  const pid_t child = fork();
  if (child == 0) become_gmsh(folder, in, out, seconds);
  if (child < 0) throw RunError(std::string("gmsh cannot be started: ") + std::strerror(errno));
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) break;
  return status;
}

// Each dataset of a .unv begins and ends with such a line. gmsh takes the part of a cut file
// without a word.
void require_whole_unv(const fs::path& file) {
  TextLines lines(file, true);
  bool is_inside = false;
  while (lines.next()) {
    const std::string& line = lines.line();
    is_inside ^= line.starts_with("    -1") && trimmed(line) == "-1";
  }
  if (is_inside)
    lines.fail("ends inside a dataset, without its last line '-1': the file is cut short");
}

// Local nodes of which each node is in the middle: two ends of an edge, the corners of a face or
// all.
std::vector<std::vector<int>> ends_of_nodes(ElementType type) {
  std::vector<int> all(n_corners(type));
  std::iota(all.begin(), all.end(), 0);
  std::vector<std::vector<int>> ends(n_nodes(type), all);
  for (int s = 1; s <= n_sides(type); ++s) {
    const std::vector<int>& nodes = side_nodes(type, s);
    const std::size_t n = n_corners(side_kind(type, s));
    for (std::size_t i = n; i < nodes.size(); ++i) {
      const std::size_t edge = i - n;
      if (i < 2 * n) ends[nodes[i]] = {nodes[edge], nodes[(edge + 1) % n]};
      if (i == 2 * n) ends[nodes[i]] = {nodes.begin(), nodes.begin() + n};
    }
  }
  return ends;
}

// gmsh takes VTK's order of solids of second order for another one, and VTK's wedges are mirrored
// (VTK, vtkCellType.h). The places of nodes decide.
void order_by_places(Mesh& mesh) {
  for (Block& block : mesh.blocks) {
    if (dimension(block.type) != 3) continue;
    const auto ends = ends_of_nodes(block.type);
    const int n = n_nodes(block.type), corners = n_corners(block.type);
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      auto row = block.connectivity.row(e);
      const auto x = [&](int a) -> Vector3 { return mesh.coordinates.row(row[a]); };
      if (corners == 6 && (x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0)) < 0)
        for (const int a : {1, 4}) std::swap(row[a], row[a + 1]);
      for (int a = corners; a < n; ++a) {
        Vector3 middle = Vector3::Zero();
        for (const int end : ends[a]) middle += x(end) / static_cast<double>(ends[a].size());
        int nearest = a;
        for (int b = a; b < n; ++b)
          if ((x(b) - middle).norm() < (x(nearest) - middle).norm()) nearest = b;
        std::swap(row[a], row[nearest]);
      }
    }
  }
}

}  // namespace

Mesh read_with_gmsh(const fs::path& file) {
  std::error_code error;
  if (file.extension() == ".unv" || file.extension() == ".UNV") require_whole_unv(file);
  const PrivateFolder folder;
  const fs::path in = folder.path() / ("mesh" + file.extension().string());
  fs::create_symlink(fs::absolute(file), in);
  const TemporaryFile converted(folder.path() / "mesh.msh");  // never put in place
  const fs::path& out = converted.path();
  const int status = run_gmsh(folder.path(), in, out, seconds_to_read(fs::file_size(file, error)));
  if (WIFEXITED(status) && WEXITSTATUS(status) == no_program)
    throw RunError(file.string() +
                   ": the program gmsh reads this format, and it is not there: install gmsh");
  const std::string cure =
      ": the program gmsh cannot read it: is it damaged, or of another format? (try: gmsh " +
      file.string() + ")";
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || fs::file_size(out, error) == 0)
    throw InputError(file.string() + cure);
  try {
    Mesh mesh = read_gmsh(out);
    if (in.extension() != ".unv" && in.extension() != ".UNV") order_by_places(mesh);
    if (mesh.blocks.empty())
      throw InputError(file.string() + ": has no elements that gmsh reads: is it damaged?");
    return mesh;
  } catch (const InputError& wrong) {
    std::string text = wrong.what();
    // Of a damaged file gmsh may write no mesh: its sections are not those of the file
    if (text.find('$') != std::string::npos)
      throw InputError(file.string() +
                       ": gmsh finds no whole mesh in it: is it cut short, or damaged?");
    for (std::size_t at; (at = text.find(out.string())) != std::string::npos;)
      text.replace(at, out.string().size(), file.string());
    throw InputError(text);
  }
}

}  // namespace cbr
