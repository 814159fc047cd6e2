include(CbrFindLibrary)
cbr_find_library(OpenBLAS OpenBLAS::OpenBLAS HEADER openblas_config.h NAMES openblas SUFFIXES openblas-pthread)
