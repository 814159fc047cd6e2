include(CbrFindLibrary)
cbr_find_library(METIS METIS::METIS HEADER metis.h NAMES metis)
