# Text files into C++: cmake -DOUT=FILE.cpp -DHEADER=HEADER -DFILES="PATH;PATH" -P embed_text.cmake
# gives each file as a string in namespace vir::results::page, called after it: report.css as report_css.
set(text "// Made from the files it is called after.\n#include \"${HEADER}\"\n\nnamespace vir::results::page {\n")
foreach(path ${FILES})
  get_filename_component(name ${path} NAME)
  string(MAKE_C_IDENTIFIER ${name} name)
  file(READ ${path} content)
  string(APPEND text "const char* const ${name} = R\"PAGE(${content})PAGE\";\n")
endforeach()
file(WRITE ${OUT} "${text}}  // namespace vir::results::page\n")
