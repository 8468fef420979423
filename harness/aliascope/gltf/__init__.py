"""glTF 2.0, in and out: files of other programs as scenes, and scenes as files for other programs.

Khronos Group, glTF 2.0 Specification (ISO/IEC 12113:2022), with KHR_lights_punctual, KHR_materials_emissive_strength,
KHR_materials_unlit and KHR_mesh_quantization.
"""
