"""Encirclement by cells: OA-ECBVC (Wang et al., arXiv 2312.01326) and the methods that it is compared with."""
