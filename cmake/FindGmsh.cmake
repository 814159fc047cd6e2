include(CbrFindLibrary)
cbr_find_library(Gmsh Gmsh::Gmsh HEADER gmsh.h NAMES gmsh)
