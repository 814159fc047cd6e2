# The Debian package that `make deb` makes with cpack: what `make install` installs, under /usr.
file(STRINGS ${PROJECT_SOURCE_DIR}/packages.txt packages REGEX "^[a-z]")
set(python_packages ${packages})
list(FILTER python_packages INCLUDE REGEX "^python3-")
set(library_packages ${packages})
list(FILTER library_packages INCLUDE REGEX "^lib.*-dev$")
list(REMOVE_ITEM library_packages libgmsh-dev libgtest-dev)  # of the tests

# Modules are in a folder of one version of Python: lib/python3.11/dist-packages.
if(NOT CBR_PYTHON_FOLDER MATCHES "python3\\.([0-9]+)/")
  message(FATAL_ERROR "CBR_PYTHON_FOLDER is ${CBR_PYTHON_FOLDER}, expected lib/python3.N/dist-packages")
endif()
math(EXPR next_python "${CMAKE_MATCH_1} + 1")
set(python "python3 (>= 3.${CMAKE_MATCH_1}~)" "python3 (<< 3.${next_python}~)")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "maintainers of cbr <maintainers@cbr.invalid>")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "${PROJECT_DESCRIPTION}
 cbr-reduce reduces finite element components to superelements that keep the faces of their interface.
 cbr-dyn simulates motion and contact of superelements and meshes; cbr-skin adds shells to surfaces.
 The suggested packages are needed to compile C++ programs that use find_package(cbr).")
# Shared libraries come from dpkg-shlibdeps.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
list(JOIN python_packages ", " python_packages)
list(JOIN python ", " python)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "${python}, ${python_packages}")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS gmsh)
list(JOIN library_packages ", " CPACK_DEBIAN_PACKAGE_SUGGESTS)
include(CPack)
