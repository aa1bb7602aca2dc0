# Destinations for `cmake --install` and `cpack`. The program looks for its image module beside itself
# and in ../lib/sightline.
set(manual_files sightline.1 sightline.bash _sightline)
set(forms man bash zsh)
foreach(file form IN ZIP_LISTS manual_files forms)
  add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/manual/${file}
      COMMAND ${CMAKE_COMMAND} -E env ASAN_OPTIONS=detect_leaks=0
              $<TARGET_FILE:sightline> manual ${form} > ${PROJECT_BINARY_DIR}/manual/${file}
      DEPENDS sightline)
  list(APPEND manual ${PROJECT_BINARY_DIR}/manual/${file})
endforeach()
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/manual)
# Debian requires compressed manual pages; -n omits the time, so that the same source gives the same package.
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/manual/sightline.1.gz
    COMMAND gzip -9nkf ${PROJECT_BINARY_DIR}/manual/sightline.1
    DEPENDS ${PROJECT_BINARY_DIR}/manual/sightline.1)
add_custom_target(manual ALL DEPENDS ${manual} ${PROJECT_BINARY_DIR}/manual/sightline.1.gz)

install(TARGETS sightline RUNTIME DESTINATION bin)
install(TARGETS sightline_oiio LIBRARY DESTINATION lib/sightline)
install(PROGRAMS tools/charts DESTINATION libexec/sightline)
install(DIRECTORY tools/charting DESTINATION libexec/sightline FILES_MATCHING PATTERN "*.py" PATTERN "*.json")
install(FILES ${PROJECT_BINARY_DIR}/bin/sightline_oiio.order DESTINATION lib/sightline)
install(FILES ${PROJECT_BINARY_DIR}/manual/sightline.1.gz DESTINATION share/man/man1)
install(FILES ${PROJECT_BINARY_DIR}/manual/sightline.bash RENAME sightline
        DESTINATION share/bash-completion/completions)
install(FILES ${PROJECT_BINARY_DIR}/manual/_sightline DESTINATION share/zsh/vendor-completions)
install(FILES LICENSE RENAME copyright DESTINATION share/doc/sightline)
install(FILES README.md docs/batch.md docs/catalogue.md docs/data_sets.md docs/farm.md docs/shapes.md docs/statistics.md
              docs/batch-manifest.schema.json
        DESTINATION share/doc/sightline)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_CONTACT "The Sightline developers <sightline@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "renders glTF 2.0 assets on CPUs, one by one or thousands")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "ffmpeg, python3-matplotlib") # films; the charts of reports
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON) # including the module, which no program links
include(CPack)
