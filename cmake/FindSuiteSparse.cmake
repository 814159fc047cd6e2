include(CbrFindLibrary)
cbr_find_library(SuiteSparse SuiteSparse::CHOLMOD HEADER cholmod.h NAMES cholmod SUFFIXES suitesparse)
