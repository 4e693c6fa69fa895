"""The posterior map: which inclusions a list of sites speaks for, and which it leaves room for.

Contents: the model of a map (background, inclusions, noise), its posterior by reversible-jump
Markov chains, and all that is read out of it.

    log k_i = background(x_i, y_i, t_i) + log(1 + sum_j e_j g_j(x_i, y_i)) + noise_i

Inside, lengths are in mm: all that has a length here is a few of them.
"""
