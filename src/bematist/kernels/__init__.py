"""Compiled kernels: plain float64 arrays in and out, SI, no defaults, nothing of ours imported but other kernels."""
