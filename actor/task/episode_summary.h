// The summary of an episode lives with the wire contracts, because evaluation reports are made without SUMO.
#pragma once

#include "proto/evaluation/episode_summary.h"  // IWYU pragma: export
