# Flags that everything which shares objects with the framework must be compiled with: they travel with the
# exported target deform::flags, so that a plugin from outside gets the same ones.
add_library(deform_flags INTERFACE)
add_library(deform::flags ALIAS deform_flags)
target_compile_features(deform_flags INTERFACE cxx_std_20)
target_compile_options(deform_flags INTERFACE
  -march=x86-64-v2       # one baseline for all: Eigen's alignment, part of the ABI tag, follows from it
  -fno-math-errno -fno-trapping-math -ffp-contract=off
  $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)
if(DEFORM_SANITIZERS)
  target_compile_options(deform_flags INTERFACE
    -fsanitize=${DEFORM_SANITIZERS} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(deform_flags INTERFACE -fsanitize=${DEFORM_SANITIZERS})
endif()
if(DEFORM_FUZZ)
  target_compile_options(deform_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Warnings are for our own code only.
add_library(deform_warnings INTERFACE)
target_compile_options(deform_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
  -Woverloaded-virtual $<$<CXX_COMPILER_ID:GNU>:-Wcast-align=strict> -Wdouble-promotion
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # false alarms of g++ 12 in std::string, as is the next one
  $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-missing-field-initializers>
  $<$<BOOL:${DEFORM_WERROR}>:-Werror>)
