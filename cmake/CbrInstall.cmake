# The installed package: headers under include/cbr, libraries, and cbrConfig.cmake.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/cbr)
foreach(part common reducer skinner dynamics)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${part} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cbr FILES_MATCHING PATTERN "*.hpp")
  if(TARGET cbr_${part})
    set_target_properties(cbr_${part} PROPERTIES EXPORT_NAME ${part})
    install(TARGETS cbr_${part} EXPORT cbrTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  endif()
endforeach()
install(EXPORT cbrTargets NAMESPACE cbr:: DESTINATION ${package_dir})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/cbrConfig.cmake.in ${PROJECT_BINARY_DIR}/cbrConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cbrConfigVersion.cmake COMPATIBILITY SameMinorVersion)
file(GLOB find_modules ${PROJECT_SOURCE_DIR}/cmake/Find*.cmake)
install(FILES ${PROJECT_BINARY_DIR}/cbrConfig.cmake ${PROJECT_BINARY_DIR}/cbrConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/CbrFindLibrary.cmake ${find_modules} DESTINATION ${package_dir})

# The Python package, where Debian's Python looks below /usr/local, and its command.
set(CBR_PYTHON /usr/bin/python3 CACHE FILEPATH "Python with h5py, numpy and matplotlib, for tests and plots")
execute_process(COMMAND ${CBR_PYTHON} -c "import sys; print('lib/python%d.%d/dist-packages' % sys.version_info[:2])"
  OUTPUT_VARIABLE CBR_PYTHON_FOLDER OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/cbr DESTINATION ${CBR_PYTHON_FOLDER} PATTERN __pycache__ EXCLUDE)
configure_file(${PROJECT_SOURCE_DIR}/cmake/cbr-report.in ${PROJECT_BINARY_DIR}/cbr-report @ONLY)
install(PROGRAMS ${PROJECT_BINARY_DIR}/cbr-report DESTINATION ${CMAKE_INSTALL_BINDIR})

# What shells and man look for.
foreach(program cbr-reduce cbr-skin cbr-dyn cbr-report)
  install(FILES ${PROJECT_SOURCE_DIR}/scripts/completion.bash DESTINATION share/bash-completion/completions RENAME ${program})
  install(CODE "execute_process(COMMAND ${PROJECT_SOURCE_DIR}/scripts/man-page \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}/${program}
    OUTPUT_FILE ${PROJECT_BINARY_DIR}/${program}.1 COMMAND_ERROR_IS_FATAL ANY)")
  install(FILES ${PROJECT_BINARY_DIR}/${program}.1 DESTINATION share/man/man1)
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/cbr RENAME copyright)
# Debian's zsh looks into the first below /usr/local, and into the second below /usr
foreach(folder site-functions vendor-completions)
  install(FILES ${PROJECT_SOURCE_DIR}/scripts/completion.zsh DESTINATION share/zsh/${folder} RENAME _cbr)
endforeach()
