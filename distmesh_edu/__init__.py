"""Mesh generation with signed distance functions."""
