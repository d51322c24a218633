"""Car detection by Point-GNN (Shi and Rajkumar, CVPR 2020) on a CPU, with NumPy and SciPy only.

Weights come from the authors' TensorFlow checkpoints, which `checkpoint` reads without TensorFlow. Boxes are rows of x, y, z
(middle of the bottom face, y down), length, height, width in meters and yaw in radians, in the camera's frame, as KITTI's
labels are.
"""
