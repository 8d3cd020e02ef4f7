"""Linearly transformed cosines symmetric about the normal, and the light of polygons through them."""

from ecfit.ltc.polygon import lobe_share as lobe_share
from ecfit.ltc.polygon import polygon_share as polygon_share
from ecfit.ltc.stretched import stretched_cosine as stretched_cosine
