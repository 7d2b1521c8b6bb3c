# Debian 12 packages only; tests/run.sh and deploy/quickstart.sh install them.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(CycloneDDS 0.10 REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(tl-expected REQUIRED)
find_package(zstd REQUIRED)
find_package(pugixml REQUIRED)
find_package(GTest REQUIRED)
include(GoogleTest)

# Of LCM the generated types alone: its receiver puts forged fragments together (common/telemetry/lcm_receiver.h).
find_path(LCM_INCLUDE_DIR lcm/lcm_coretypes.h REQUIRED)
find_program(LCM_GEN lcm-gen REQUIRED)
add_library(lcm::types INTERFACE IMPORTED)
set_target_properties(lcm::types PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${LCM_INCLUDE_DIR})

# Debian's libxxhash has no usable CMake package.
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)
find_library(XXHASH_LIBRARY xxhash REQUIRED)
add_library(xxhash::xxhash SHARED IMPORTED)
set_target_properties(xxhash::xxhash PROPERTIES IMPORTED_LOCATION ${XXHASH_LIBRARY}
                                                INTERFACE_INCLUDE_DIRECTORIES ${XXHASH_INCLUDE_DIR})

# librsvg has no CMake package at all.
find_package(PkgConfig REQUIRED)
pkg_check_modules(LIBRSVG REQUIRED IMPORTED_TARGET GLOBAL librsvg-2.0)
