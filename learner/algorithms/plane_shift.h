// Bird's-eye planes moved by whole pixels: the augmentation of DrQ (Kostrikov, Yarats and Fergus 2021), on
// bits.
#pragma once

#include <cstdint>
#include <span>

namespace dadrl {

constexpr int kMaxShiftPixels = 16;

// What is seen moves down and to the right.
struct PlaneShift {
  int rows = 0;
  int columns = 0;
};

// Uniform over [-pixels, pixels] in both directions, from two standard normal draws: so a NoiseSource is all
// that decides a training.
PlaneShift ShiftOf(float row_noise, float column_noise, int pixels);

// The planes of one observation ("context" of DrivingShape) into `out`, of the same size. What comes in at a
// border repeats the border. Shifts are at most kMaxShiftPixels.
void ShiftPlanes(std::span<const uint8_t> planes, PlaneShift shift, uint8_t* out);

}  // namespace dadrl
