# Copies the documents, with what they show and link to, to the folder DOCUMENTS, as they lie in the project.
get_filename_component(project ${CMAKE_CURRENT_LIST_DIR} DIRECTORY)
file(REMOVE_RECURSE ${DOCUMENTS})
file(COPY ${project}/README.md ${project}/LIMITS.md ${project}/CONTRIBUTING.md ${project}/CHANGELOG.md DESTINATION ${DOCUMENTS})
foreach(folder apps features segmentation registration io test)
  file(COPY ${project}/${folder} DESTINATION ${DOCUMENTS} FILES_MATCHING
       PATTERN *.md PATTERN *.png PATTERN *.gif PATTERN *.svg PATTERN *.json PATTERN *.ini PATTERN *.csv PATTERN *.py
       PATTERN golden EXCLUDE PATTERN __pycache__ EXCLUDE)
endforeach()
