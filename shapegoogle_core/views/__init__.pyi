# SPDX-License-Identifier: MIT
from shapegoogle_core.views.directions import VIEW_ROTATIONS as VIEW_ROTATIONS
from shapegoogle_core.views.directions import symmetries as symmetries
from shapegoogle_core.views.gradients import CODE_BYTES as CODE_BYTES
from shapegoogle_core.views.gradients import GradientViews as GradientViews
from shapegoogle_core.views.learning import learn_views as learn_views
from shapegoogle_core.views.network_views import NetworkViews as NetworkViews
from shapegoogle_core.views.pictures import normal_pictures as normal_pictures
from shapegoogle_core.views.points import surface_points as surface_points
from shapegoogle_core.views.shape_views import ShapeViews as ShapeViews
from shapegoogle_core.views.shape_views import packed_size as packed_size
from shapegoogle_core.views.shape_views import unpack_descriptors as unpack_descriptors
from shapegoogle_core.views.view_model import ViewModel as ViewModel

__all__: list[str]
