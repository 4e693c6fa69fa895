"""From estimates at single sites to a stiffness map and the stiff regions in it.

Contents: the grid of sites, the fusion of estimates at each site, the surface through the sites,
the regions that stand out.
"""
