// scenes/whitted.gltf for POV-Ray, whose y is up and whose hand is the left one: z is negated.
#version 3.7;
global_settings { assumed_gamma 1 max_trace_level 8 }
background { rgb <0.2, 0.45, 0.8> }
camera {
  perspective location <0.25, 2.3, -8> right x*image_width/image_height up y
  direction z*0.5/tan(radians(19)) look_at <0.25, 1.85, 0>
}
light_source { <-5, 14, -6> rgb 1 }
plane {
  y, 0
  clipped_by { box { <-7, -1, -6>, <5, 1, 18> } }
  pigment { checker rgb <0.956, 0.680, 0.007>, rgb <0.680, 0.007, 0.005> translate <1, 0, 0> }
  finish { diffuse 1 ambient 0 }
}
sphere {
  <-0.35, 2.35, -1.9>, 1.15
  pigment { rgbf 1 }
  finish { diffuse 0 ambient 0 reflection { 0, 1 fresnel on } conserve_energy }
  interior { ior 1.5 }
}
sphere {
  <1.35, 1.55, 0.6>, 1.15
  pigment { rgb 0 }
  finish { diffuse 0 ambient 0 reflection 0.85 }
}
