# SPDX-License-Identifier: MIT
from shapegoogle_core.registration.alignment import Alignment as Alignment
from shapegoogle_core.registration.alignment import align as align
from shapegoogle_core.registration.alignment import measure as measure
from shapegoogle_core.registration.exact_fit import RoughPose as RoughPose
from shapegoogle_core.registration.exact_fit import fit_exactly as fit_exactly
from shapegoogle_core.registration.exact_fit import rough_pose as rough_pose
from shapegoogle_core.registration.frames import Frame as Frame
from shapegoogle_core.registration.isometry import Isometry as Isometry
from shapegoogle_core.registration.isometry import functional_map as functional_map
from shapegoogle_core.registration.isometry import spectral_difference as spectral_difference
from shapegoogle_core.registration.local_words import LocalSettings as LocalSettings
from shapegoogle_core.registration.local_words import LocalWords as LocalWords
from shapegoogle_core.registration.local_words import fit_local_words as fit_local_words
from shapegoogle_core.registration.prepared_sample import PART_SCALES as PART_SCALES
from shapegoogle_core.registration.prepared_sample import SCALES as SCALES
from shapegoogle_core.registration.prepared_sample import SHARED_SCALES as SHARED_SCALES
from shapegoogle_core.registration.prepared_sample import PreparedSample as PreparedSample
from shapegoogle_core.registration.sample import SampleSettings as SampleSettings
from shapegoogle_core.registration.sample import SurfaceSample as SurfaceSample
from shapegoogle_core.registration.sample import farthest_points as farthest_points
from shapegoogle_core.registration.sample import sample_surface as sample_surface
from shapegoogle_core.registration.support import supports as supports
from shapegoogle_core.registration.surface_fit import Fit as Fit
from shapegoogle_core.registration.surface_fit import Surface as Surface
from shapegoogle_core.registration.surface_fit import TangentPlanes as TangentPlanes
from shapegoogle_core.registration.surface_fit import fit_numbered as fit_numbered
from shapegoogle_core.registration.surface_fit import fit_surface as fit_surface
from shapegoogle_core.registration.surface_fit import frame_between as frame_between
from shapegoogle_core.registration.surface_fit import mirrored as mirrored

__all__: list[str]
