package org.mrsfi.interop;

import com.google.gson.JsonObject;
import java.io.ByteArrayOutputStream;
import java.io.File;
import java.io.PrintStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;
import org.eclipse.emf.ecore.resource.Resource;
import org.eclipse.emf.ecore.resource.ResourceSet;
import org.eclipse.emf.ecore.util.EcoreUtil;
import org.eclipse.epsilon.egl.EglFileGeneratingTemplate;
import org.eclipse.epsilon.egl.EglFileGeneratingTemplateFactory;
import org.eclipse.epsilon.emc.emf.InMemoryEmfModel;
import org.eclipse.epsilon.eol.EolModule;
import org.eclipse.epsilon.eol.IEolModule;

/** Runs EOL queries and EGL templates over models. */
final class Programs {

    private static final String MODEL_NAME = "M";

    private Programs() {}

    /**
     * Runs one EOL program.
     *
     * @param request paths under "metamodels", "models" (one model together) and "program"
     * @return what the program printed
     */
    static Object query(JsonObject request) throws Exception {
        EolModule module = new EolModule();
        ByteArrayOutputStream printed = new ByteArrayOutputStream();
        try {
            parse(module, new File(request.get("program").getAsString()));
            PrintStream stream = new PrintStream(printed, true, StandardCharsets.UTF_8);
            module.getContext().setOutputStream(stream);
            module.getContext().getModelRepository().addModel(model(request));
            module.execute();
        } finally {
            module.getContext().getModelRepository().dispose();
        }
        return Map.of("printed", printed.toString(StandardCharsets.UTF_8));
    }

    /**
     * Runs one EGL template.
     *
     * @param request paths under "metamodels", "models" (one model together), "program" and
     *     "target"; what stands in the target's protected regions is kept
     * @return what the target now holds
     */
    static Object generate(JsonObject request) throws Exception {
        Path target = Path.of(request.get("target").getAsString()).toAbsolutePath();
        EglFileGeneratingTemplateFactory factory = new EglFileGeneratingTemplateFactory();
        try {
            factory.setOutputRoot(target.getParent().toString());
            factory.getContext().getModelRepository().addModel(model(request));
            File program = new File(request.get("program").getAsString()).getAbsoluteFile();
            var template = (EglFileGeneratingTemplate) factory.load(program.toURI());
            template.process();
            template.generate(target.getFileName().toString());
        } finally {
            factory.getContext().getModelRepository().dispose();
        }
        return Map.of("written", Files.readString(target));
    }

    private static InMemoryEmfModel model(JsonObject request) {
        return model(new Models(request), Models.paths(request, "models"));
    }

    /** Returns files as one model of Epsilon, which finds the types of all metamodels in it. */
    static InMemoryEmfModel model(Models models, List<String> files) {
        ResourceSet resources = models.resources();
        for (String file : files) {
            resources.getResource(Models.uri(file), true);
        }
        EcoreUtil.resolveAll(resources);
        Resource first = resources.getResources().get(0);
        InMemoryEmfModel model = new InMemoryEmfModel(MODEL_NAME, first, models.packages());
        model.setExpand(true);
        return model;
    }

    /** Parses a program and stops at its first mistake. */
    static void parse(IEolModule module, File program) throws Exception {
        if (!module.parse(program)) {
            throw new IllegalArgumentException(
                    program + " does not parse: " + module.getParseProblems());
        }
    }
}
