# Run by CPack between staging and packing: adds what only packages have, man pages, copyright and changelogs.
find_program(HELP2MAN help2man REQUIRED)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# The time of what was packed, so that packing it again gives the same files.
execute_process(COMMAND git -C ${CPACK_STBVH_DOCUMENTS} log -1 --format=%ct OUTPUT_VARIABLE seconds
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(seconds AND NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  set(ENV{SOURCE_DATE_EPOCH} ${seconds})
endif()
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(CPACK_DEBIAN_VERSION ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})

# man_page(PROGRAM PURPOSE [HELP_OPTION]) of a program in the staged folder. help2man asks a script that answers for
# the program, with its help in the form that help2man reads.
function(man_page program purpose)
  set(help_options --help ${ARGN})
  list(GET help_options -1 help_option)
  execute_process(COMMAND ${usr}/bin/${program} ${help_option} OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE "(^|\n)usage:" "\\1Usage:" help "${help}")
  string(REGEX REPLACE "\nSubcommands:\n" "\n" help "${help}")  # each has a heading of its own
  string(REGEX REPLACE "\n([a-z]+)\n  ([^\n]*)\n" "\n\\1:\n  \\2\n\n" help "${help}")
  string(REGEX REPLACE "\n  Options:\n" "\n" help "${help}")
  set(work ${CPACK_TEMPORARY_DIRECTORY}/man)
  file(WRITE ${work}/help "${help}")
  file(CONFIGURE OUTPUT ${work}/${program} @ONLY CONTENT [[#!/bin/sh
if [ "$1" = --version ]; then exec @usr@/bin/@program@ --version; fi
cat @work@/help
]])
  file(CHMOD ${work}/${program} PERMISSIONS OWNER_READ OWNER_EXECUTE)
  set(page ${usr}/share/man/man1/${program}.1)
  file(MAKE_DIRECTORY ${usr}/share/man/man1)
  run(${HELP2MAN} --no-info --name=${purpose} --output=${page} ${work}/${program})
  run(gzip -9n ${page})
  file(REMOVE_RECURSE ${work})
endfunction()

foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} name)
  set(package ${CPACK_DEBIAN_${name}_PACKAGE_NAME})
  set(usr ${CPACK_TEMPORARY_DIRECTORY}/${component}/usr)
  file(REMOVE_RECURSE ${usr}/share/doc/stbvh)  # the licence, which the copyright file names
  set(documents ${usr}/share/doc/${package})
  file(MAKE_DIRECTORY ${documents})
  configure_file(${CPACK_STBVH_DOCUMENTS}/copyright ${documents}/copyright COPYONLY)
  configure_file(${CPACK_STBVH_CHANGELOG} ${documents}/changelog COPYONLY)
  configure_file(${CPACK_STBVH_DOCUMENTS}/changelog.Debian.in ${documents}/changelog.Debian @ONLY)
  run(gzip -9n ${documents}/changelog ${documents}/changelog.Debian)
  if(component STREQUAL "Preload")
    man_page(stbvh-run "run a program of Embree 3 with STBVH inside")
  elseif(component STREQUAL "Harness")
    man_page(stbvh-ab "compare structures for motion blur in speed, memory and error" --help-all)
    man_page(stbvh-preview "show moving scenes in a window while they render")
  endif()
endforeach()
