include(CbrFindLibrary)
cbr_find_library(xxHash xxHash::xxHash HEADER xxhash.h NAMES xxhash)
