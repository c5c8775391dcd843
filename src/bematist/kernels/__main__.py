"""`python -m bematist.kernels`: compile every kernel once into the cache, so that the first real run need not wait."""
