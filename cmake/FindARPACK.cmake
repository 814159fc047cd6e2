include(CbrFindLibrary)
cbr_find_library(ARPACK ARPACK::ARPACK HEADER arpack.h NAMES arpack SUFFIXES arpack)
