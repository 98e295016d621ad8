"""A species of small trees, which grow in no time."""

SMALL = """\
about = "A small tree for tests. It has two sentences."

[tree]
base_size = 0.2
levels = 2
ratio = { value = 0.02, range = [0.01, 0.03] }
scale = { value = 5.0, range = [3.0, 8.0], unit = "m", why = "it is small" }

[trunk]
curve_res_0 = 2

[level_1]
branches_1 = { value = 6, range = [4, 9] }
curve_res_1 = 2
down_angle_1 = { value = 60.0, spread = 10.0, unit = "deg" }
length_1 = { value = 0.3, range = [0.2, 0.4] }

[leaves]
leaves = 4
"""
