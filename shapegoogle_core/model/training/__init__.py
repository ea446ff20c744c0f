# SPDX-License-Identifier: MIT
"""Training of a model on shapes and versions of them."""

from shapegoogle_core.model.training.train import TrainingShape, train_model

__all__ = ["TrainingShape", "train_model"]
