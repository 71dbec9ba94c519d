package org.mrsfi.interop;

import com.google.gson.JsonArray;
import com.google.gson.JsonElement;
import com.google.gson.JsonObject;
import java.io.File;
import java.io.IOException;
import java.util.ArrayList;
import java.util.Base64;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.TreeMap;
import org.eclipse.emf.common.util.WrappedException;
import org.eclipse.emf.ecore.EObject;
import org.eclipse.emf.ecore.resource.Resource;
import org.eclipse.emf.ecore.util.EcoreUtil;
import org.eclipse.epsilon.emc.emf.InMemoryEmfModel;
import org.eclipse.epsilon.eol.exceptions.EolRuntimeException;
import org.eclipse.epsilon.evl.EvlModule;
import org.eclipse.epsilon.evl.execute.FixInstance;
import org.eclipse.epsilon.evl.execute.UnsatisfiedConstraint;
import org.eclipse.epsilon.evl.execute.context.EvlContext;
import org.eclipse.epsilon.evl.trace.ConstraintTraceItem;

/** Runs EVL constraints over models, and the fixes that they offer. */
final class Validation {

    private final Models models;
    private final EvlModule module = new EvlModule();

    private Validation(JsonObject request) throws Exception {
        models = new Models(request);
        Programs.parse(module, new File(request.get("program").getAsString()));
    }

    /**
     * Checks every model of a request, and fixes what can be fixed in memory.
     *
     * @param request paths under "metamodels" and "program"; lists of files that belong together
     *     under "models"
     * @return what EMF has against each model and, if it can be loaded at all, which constraints
     *     were checked how often, the unsatisfied ones, and what saving writes before and after
     *     their fixes, in the order of the request
     */
    static Object validate(JsonObject request) throws Exception {
        Validation validation = new Validation(request);
        List<Object> answers = new ArrayList<>();
        for (JsonElement entry : request.getAsJsonArray("models")) {
            List<String> files = new ArrayList<>();
            ((JsonArray) entry).forEach(file -> files.add(file.getAsString()));
            answers.add(validation.answer(files));
        }
        return Map.of("models", answers);
    }

    private Map<String, Object> answer(List<String> files) throws Exception {
        List<String> errors = new ArrayList<>();
        Map<String, Object> answer = new LinkedHashMap<>();
        answer.put("models", files);
        answer.put("errors", errors);
        try {
            for (String file : files) {
                errors.addAll(Saving.problems(models.load(file)));
            }
        } catch (WrappedException problem) {
            errors.add("load: " + problem.getCause().getMessage());
            return answer;
        } catch (IllegalArgumentException problem) {
            errors.add("load: " + problem.getMessage());
            return answer;
        }
        answer.putAll(verdict(files));
        return answer;
    }

    private Map<String, Object> verdict(List<String> files) throws Exception {
        InMemoryEmfModel model = Programs.model(models, files);
        module.setContext(new EvlContext());
        module.getContext().getModelRepository().addModel(model);
        try {
            Set<UnsatisfiedConstraint> unsatisfied = module.execute();
            Map<String, Object> verdict = new LinkedHashMap<>();
            verdict.put("unsatisfied", unsatisfied.stream().map(Validation::description).toList());
            verdict.put("checked", checked());
            List<FixInstance> fixes = new ArrayList<>();
            unsatisfied.forEach(found -> fixes.addAll(found.getFixes()));
            verdict.put("before", fixes.isEmpty() ? Map.of() : contents(model));
            for (FixInstance fix : fixes) {
                fix.perform();
            }
            verdict.put("after", fixes.isEmpty() ? Map.of() : contents(model));
            return verdict;
        } finally {
            module.getContext().getModelRepository().dispose();
        }
    }

    /** Returns on how many elements each constraint was checked. */
    private Map<String, Integer> checked() {
        Map<String, Integer> counts = new TreeMap<>();
        for (ConstraintTraceItem item : module.getContext().getConstraintTrace()) {
            counts.merge(item.getConstraint().getName(), 1, Integer::sum);
        }
        return counts;
    }

    /** Returns the bytes of every file of a model, as Eclipse would save it, in Base64. */
    private static Map<String, String> contents(InMemoryEmfModel model) throws IOException {
        Map<String, String> contents = new TreeMap<>();
        for (Resource resource : model.getResource().getResourceSet().getResources()) {
            byte[] bytes = Saving.bytes(resource);
            String path = resource.getURI().toFileString();
            contents.put(path, Base64.getEncoder().encodeToString(bytes));
        }
        return contents;
    }

    static Map<String, Object> description(UnsatisfiedConstraint unsatisfied) {
        EObject element = (EObject) unsatisfied.getInstance();
        Map<String, Object> answer = new LinkedHashMap<>();
        answer.put("constraint", unsatisfied.getConstraint().getName());
        answer.put("severity", unsatisfied.getConstraint().isCritique() ? "warning" : "error");
        answer.put("class", element.eClass().getName());
        answer.put("id", EcoreUtil.getID(element));
        answer.put("path", Models.path(element));
        answer.put("file", element.eResource().getURI().toFileString());
        answer.put("message", unsatisfied.getMessage());
        answer.put("fixes", titles(unsatisfied));
        return answer;
    }

    private static List<String> titles(UnsatisfiedConstraint unsatisfied) {
        List<String> titles = new ArrayList<>();
        for (FixInstance fix : unsatisfied.getFixes()) {
            try {
                titles.add(fix.getTitle());
            } catch (EolRuntimeException problem) {
                throw new IllegalStateException(problem);
            }
        }
        return titles;
    }
}
