include(CbrFindLibrary)
cbr_find_library(LAPACKE LAPACKE::LAPACKE HEADER lapacke.h NAMES lapacke lapack)
