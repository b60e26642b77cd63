# A page with everything it names put in, written as a C array:
# cmake -DFROM=view -DPAGE=page -DARRAY=ffp_page_template -DTO=page.c [-DINSTEAD=NAME.js=OTHER.js] -P write_page.cmake
#   <link rel="stylesheet" href="NAME">  the style sheet
#   <script src="NAME"></script>         the script; all scripts share one scope
#   <script type="x-shader" src="NAME">  the shader's text, as an element whose id is NAME
file(READ ${FROM}/${PAGE}.html page)

function(ffp_put_in pattern before after)
  string(REGEX MATCHALL "${pattern}" places "${page}")
  foreach(place IN LISTS places)
    string(REGEX REPLACE "${pattern}" "\\1" name "${place}")
    file(READ ${FROM}/${name} text)
    string(REPLACE "NAME" "${name}" begin "${before}")
    string(REPLACE "${place}" "${begin}\n${text}${after}" page "${page}")
  endforeach()
  set(page "${page}" PARENT_SCOPE)
endfunction()

foreach(pair IN LISTS INSTEAD)
  string(REPLACE "=" ";" pair "${pair}")
  list(GET pair 0 name)
  list(GET pair 1 other)
  string(REPLACE "src=\"${name}\"" "src=\"${other}\"" page "${page}")
endforeach()

ffp_put_in("<link rel=\"stylesheet\" href=\"([a-z_.]+)\">" "<style>" "</style>")
ffp_put_in("<script type=\"x-shader\" src=\"([a-z_.]+)\"></script>" "<script type=\"x-shader\" id=\"NAME\">" "</script>")
ffp_put_in("<script src=\"([a-z_.]+)\"></script>" "<script>" "</script>")

file(WRITE ${TO}.html "${page}")
file(READ ${TO}.html bytes HEX)
string(REGEX REPLACE "(................................................................)" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE ${TO} "#include <stddef.h>\n\nconst unsigned char ${ARRAY}[] = {\n${bytes}\n0};\nconst size_t ${ARRAY}_size = sizeof ${ARRAY} - 1;\n")
